"""`hairpipe data check`: what the table names, and what a folder holds of it."""

import hashlib
import json

from hairpipe.app.api.third_party import third_party_files

from ....pages import HOME, data_of, tables_of

GRAPHS = sorted((HOME / "graphs").rglob("*.toml"))


def test_files_are_present_absent_or_differ(hairpipe, monkeypatch, tmp_path):
    monkeypatch.setenv("HAIRPIPE_DATA", str(tmp_path))
    first, second, third, *_ = third_party_files()
    monkeypatch.setattr("hairpipe.app.api.third_party.third_party_files", lambda: [right, second, third])
    right = first._replace(sha256=hashlib.sha256(b"right").hexdigest())
    for source, data in ((first, b"right"), (second, b"wrong")):
        (tmp_path / source.name).parent.mkdir(exist_ok=True)
        (tmp_path / source.name).write_bytes(data)
    result = hairpipe("data check --json")
    files = json.loads(result.stdout)["files"]
    assert result.exit_code == 1 and [file["state"] for file in files] == ["present", "differs", "absent"]
    assert files[2]["repository"] == third.repository and json.loads(result.stdout)["folder"] == str(tmp_path)
    lines = hairpipe("data check").stdout.splitlines()
    states = [line.split()[:2] for line in lines[2:4]]
    assert lines[0] == str(tmp_path) and states == [["present", first.name], ["differs", second.name]]
    (tmp_path / second.name).unlink()
    (tmp_path / second.name).mkdir()
    assert json.loads(hairpipe("data check --json").stdout)["files"][1]["state"] == "differs"


def test_the_table_is_of_what_lies_in_the_folder(hairpipe, third_party):
    files = json.loads(hairpipe("data check --json").stdout)["files"]
    assert [file["name"] for file in files if file["state"] != "present"] == []


def test_the_table_has_all_that_graphs_read():
    sources = {source.name: source for source in third_party_files()}
    assert set().union(*map(data_of, GRAPHS)) <= sources.keys()
    for source in sources.values():
        assert len(source.sha256) == 64 and len(source.commit) >= 12 and source.licence and "/" in source.repository


def test_each_graph_that_reads_third_party_data_has_a_counterpart():
    [rows] = [rows for _, (head, _, *rows) in tables_of(HOME / "docs/howto/data.md") if "counterpart" in head]
    paths = [[cell.split("`")[1] for cell in row.split("|")[1:4:2]] for row in rows]
    assert sorted(HOME / graph for graph, _ in paths) == [path for path in GRAPHS if data_of(path)]
    assert all((HOME / other).is_file() and not data_of(HOME / other) for _, other in paths)


def test_no_graph_names_the_folder_by_a_path():
    assert not [path for path in GRAPHS if "shared/data" in path.read_text(encoding="utf-8")]
