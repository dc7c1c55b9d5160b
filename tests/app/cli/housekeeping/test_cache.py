"""`hairpipe cache`: what is kept and what may go."""

import json
from pathlib import Path

import pytest


def listed(hairpipe, arguments: str = "") -> list[dict]:
    return json.loads(hairpipe(f"cache ls --json {arguments}").stdout)["results"]


def test_it_is_an_option_or_a_variable_or_in_the_current_folder(hairpipe, monkeypatch):
    def used(arguments: str = "") -> str:
        return json.loads(hairpipe(f"cache du --json {arguments}").stdout)["cache"]

    assert used() == "cache"
    monkeypatch.setenv("HAIRPIPE_CACHE", "variable")
    assert used() == "variable"
    assert used("--cache option") == "option"


def test_results_are_listed_and_their_sizes_add_up(computed, hairpipe):
    assert {(item["node"], item["frame"]) for item in listed(hairpipe)} >= {("seed", None), ("sum", 6)}
    header, *rows = hairpipe("cache ls").stdout.splitlines()
    assert header.split() == ["result", "type", "size", "computed", "in", "used", "key"]
    assert len(rows) == 20 and any(row.startswith("sum@6 ") and " add_up " in row for row in rows)
    types = json.loads(hairpipe("cache du --json").stdout)["types"]
    on_disk = sum(path.stat().st_size for path in Path("cache/objects").rglob("*") if path.is_file())
    assert sum(entry["size"] for entry in types.values()) == on_disk and types["add_up"]["results"] == 6
    assert hairpipe("cache du").stdout.splitlines()[-1].split()[:2] == ["total", "20"]


def test_a_cache_that_is_not_there_is_empty_and_stays_away(shot, hairpipe):
    for command in ("ls", "du", "verify", "gc --older 1d"):
        assert hairpipe(f"cache {command}").exit_code == 0
        assert not Path("cache", "actions").exists()


def test_damage_is_found_removed_and_computed_again(computed, hairpipe):
    assert hairpipe("cache verify").stdout == "all whole\n"
    victim = next(path for path in sorted(Path("cache/objects").rglob("*.bin")))
    victim.chmod(0o644)
    victim.write_bytes(b"?" * victim.stat().st_size)
    result = hairpipe("cache verify")
    assert result.exit_code == 1
    assert result.stdout == f"objects/{victim.name}\n1 file damaged and removed\n"
    assert json.loads(hairpipe("run shot.toml -j1 --json").stdout)["evaluated"] == 1
    assert json.loads(hairpipe("cache verify --json").stdout)["damaged"] == []


def test_a_store_of_somebody_else_is_refused_by_every_command(computed, hairpipe):
    Path("cache").chmod(0o777)
    for arguments in ("cache ls", "run shot.toml", "plan shot.toml", "get shot.toml sum@1 -o sum.npz"):
        result = hairpipe(arguments)
        assert result.exit_code == 2 and "HAIRPIPE_TRUST_STORE=" in result.stderr and result.stderr.count("\n") == 1


def test_results_of_given_graphs_are_kept(computed, hairpipe):
    hairpipe("run shot.toml -j1 -q --set seed.value=7")
    assert len(listed(hairpipe)) == 40
    dry = hairpipe("cache gc shot.toml --dry-run").stdout
    assert dry.startswith("20 results, ") and dry.endswith(" would go from cache\n")
    assert len(listed(hairpipe)) == 40
    assert hairpipe("cache gc shot.toml").stdout == dry.replace("would go", "removed")
    assert len(listed(hairpipe)) == 20
    assert json.loads(hairpipe("run shot.toml -j1 --json").stdout)["evaluated"] == 0


def test_limits_of_age_and_size(computed, hairpipe):
    assert "0 results" in hairpipe("cache gc --older 1h").stdout
    assert "0 results" in hairpipe("cache gc --size 1GB").stdout
    document = json.loads(hairpipe("cache gc --size 0 --json").stdout)
    assert document["results"] == 20 and listed(hairpipe) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("gc", "no criterion of what to keep (graphs, --older or --size)"),
        ("gc --older soon", "--older: 'soon' is not a measure (a number and one of s, min, h, d, w)"),
        ("gc --older 3MB", "'3MB' is not a measure"),
        ("gc --size -1GB", "'-1GB' is not a measure"),
        ("gc none.toml", "none.toml: no such file"),
        ("ls --cache shot.toml", "is a file"),
        ("gcc", "No such command 'gcc'"),
    ],
)
def test_bad_input_removes_nothing(arguments, message, computed, hairpipe):
    result = hairpipe(f"cache {arguments}")
    assert result.exit_code == 2 and message in result.stderr
    assert len(listed(hairpipe)) == 20


def test_the_doctor_names_what_a_folder_does(hairpipe, monkeypatch):
    lines = hairpipe("cache doctor").stdout.splitlines()
    assert len(lines) == 5 and all(line.startswith(("ok  ", "note")) for line in lines)
    monkeypatch.setattr("hairpipe.engine.plan.maintenance.create", lambda path: True)
    result = hairpipe("cache doctor --json")
    faults = {item["check"] for item in json.loads(result.stdout)["findings"] if item["verdict"] == "fault"}
    assert result.exit_code == 1 and faults == {"exclusive creation"}
