"""A report on disk: what it holds, what it may replace, and that it is the same twice."""

import hashlib
from pathlib import Path
from types import SimpleNamespace

import pytest

import hairpipe
from hairpipe.app.page import report
from hairpipe.app.page.assets import SCRIPTS, WEB
from hairpipe.app.page.report import FEWEST_STRANDS, write_report
from hairpipe.errors import BadInput


def digests(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_it_is_the_same_twice_and_replaces_itself(shot, tmp_path):
    write_report(shot, tmp_path / "a")
    write_report(shot, tmp_path / "b")
    assert digests(tmp_path / "a") == digests(tmp_path / "b")
    (tmp_path / "b" / "data" / "old.js").write_text("old")
    write_report(shot, tmp_path / "b")
    assert digests(tmp_path / "a") == digests(tmp_path / "b")


def test_strands_are_thinned_to_fit(shot, tmp_path):
    whole = write_report(shot, tmp_path / "whole")
    least = write_report(shot, tmp_path / "least", most_bytes=0.7 * whole.size)
    assert least.strands < 300 <= whole.strands and least.size <= 0.75 * whole.size
    with pytest.raises(BadInput, match="MB too much"):
        write_report(shot, tmp_path / "none", most_bytes=1000)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("strands", [[], ["hair.strands"]])
def test_thinning_ends_with_a_refusal_where_nothing_fits(strands, monkeypatch):
    """Also where the estimate was too low, or no strands are shown."""
    monkeypatch.setattr(report, "strands_that_fit", lambda shelf, names, room: 2 * FEWEST_STRANDS)
    shelf = SimpleNamespace(
        most=0, names=lambda: strands, node_of=str, faces=dict, document=lambda name: ({"total": 300}, b"strands")
    )
    documents = {"state": {"nodes": {}}}
    with pytest.raises(BadInput, match="MB too much"):
        report.collect(shelf, documents, 20, lambda done, of: None)


@pytest.mark.parametrize("single", [False, True])
def test_other_files_are_not_overwritten(single, shot, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(
        BadInput, match="is not a file for a report" if single else "the folder contains files that are not a report"
    ):
        write_report(shot, tmp_path / "mine", single=single)
    assert (tmp_path / "mine" / "letter.txt").read_text() == "dear"


def test_a_run_that_failed_is_shown_unchanged(folder, tmp_path):
    text = (folder / "shot.toml").read_text().replace("[picture]", '[torn]\ntype = "tear"\nin.hair = "hair"\n[picture]')
    (folder / "torn.toml").write_text(text)
    shot = hairpipe.load(folder / "torn.toml", cache=folder / "cache")
    run = shot.run(jobs=1, keep_going=True)
    write_report(shot, tmp_path / "torn", run=run)
    state = (tmp_path / "torn" / "data" / "state.js").read_text()
    assert '"state":"failed","reason":"ValueError: \\u003c/script> at frame 3"' in state
    assert '"failures":["torn@3: ValueError: \\u003c/script> at frame 3"]' in state


def test_every_file_of_the_page_is_listed_and_vendored_ones_are_described():
    names = {path.name for path in Path(str(WEB)).iterdir() if path.suffix == ".js"}
    assert names == set(SCRIPTS)
    for line in (WEB / "vendor" / "VENDORED").read_text().splitlines():
        name, version, licence, digest, source = line.split()
        assert hashlib.sha256((WEB / "vendor" / name).read_bytes()).hexdigest() == digest
        assert version[0].isdigit() and licence == "MIT" and source.startswith("npm:")
