"""Publishing: files where the graph says, whole, written only when they differ, and known again."""

import shutil
from pathlib import Path

import pytest

from hairpipe.engine.run.publish import Ledger, ledger_path

pytestmark = pytest.mark.usefixtures("kept")

DRAW = '[draw]\ntype = "draw_number"\nin.number = "sum"\npublish = "pictures/p.####.txt"\n'
SUM = repr(sum(sum(0.9 ** (f - g) * (3.0 + g) for g in range(1, f + 1)) for f in range(1, 11)))


def test_files_of_frames_carry_their_number(shot):
    shot.add(DRAW)
    assert len(shot.run(frames=[2, 4]).published) == 3
    assert sorted(path.name for path in (shot.folder / "pictures").iterdir()) == ["p.0002.txt", "p.0004.txt"]


def test_only_what_differs_is_written(shot):
    shot.run()
    path = shot.folder / "out" / "list.txt"
    right, stamp = path.read_bytes(), path.stat().st_mtime_ns
    shot.run()
    assert path.stat().st_mtime_ns == stamp
    path.write_bytes(right[:-1] + b"!")
    shot.run(force=True)
    assert path.read_bytes() == right
    path.unlink()
    shot.run()
    assert path.read_bytes() == right
    assert shot.tally()["write_list"] == 1


def test_publishing_again_keeps_permissions_and_closes_what_it_opens(shot):
    shot.run()
    path = shot.folder / "out" / "list.txt"
    path.chmod(0o600)
    before = sorted(Path("/proc/self/fd").iterdir())
    assert len(shot.run(seed__value=4).published) == 1 and path.stat().st_mode & 0o777 == 0o600
    assert sorted(Path("/proc/self/fd").iterdir()) == before


def test_companions_lie_next_to_their_file(shot):
    shot.run(list__parts="true")
    assert (shot.folder / "out" / "parts" / "sums.txt").read_text() == SUM
    (shot.folder / "out" / "parts" / "sums.txt").unlink()
    outcome = shot.run(list__parts="true")
    assert (shot.folder / "out" / "parts" / "sums.txt").exists() and outcome.evaluated == 0


def test_companions_of_other_files_are_not_overwritten(shot):
    """Two lists, each with its sums in a file of one name beside it: they go to one place only if they are the same."""
    other = '[other]\ntype = "write_list"\nin.numbers = "{}"\nparts = true\npublish = "out/other.txt"\n'
    chain = shot.path.read_text()
    shot.path.write_text(chain + other.format("sum"))
    assert shot.run(list__parts="true").exit_code == 0
    shot.path.write_text(chain.replace('"sum"', '"move"').replace("parts = true", "") + other.format("sum"))
    outcome = shot.run(list__parts="true", keep_going=True)
    (failure,) = outcome.failures
    first = "list" if str(failure.task) == "other" else "other"
    assert failure.kind == "publish" and outcome.exit_code == 1
    place = shot.folder / "out" / "parts" / "sums.txt"
    assert failure.message.startswith(f"cannot publish to {place}: '{first}' has published another file at this path")
    assert outcome.published == (str(shot.folder / "out" / f"{first}.txt"),)


def test_a_companion_does_not_overwrite_an_input(shot):
    mine = shot.folder / "out" / "parts" / "sums.txt"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    (failure,) = shot.run(list__parts="true", seed__file="out/parts/sums.txt").failures
    assert failure.kind == "publish" and f"{mine}: the path is an input of 'seed'" in failure.message
    assert mine.read_text() == "mine" and not (shot.folder / "out" / "list.txt").exists()


def test_companion_outside_of_its_folder_is_refused(shot):
    shot.edit("write_list.py", "parts/sums.txt", "../sums.txt")
    (failure,) = shot.run(list__parts="true").failures
    assert "not a relative name" in failure.message
    assert not (shot.folder / "sums.txt").exists()


def test_place_that_cannot_be_written_is_named_and_the_result_kept(shot):
    (shot.folder / "out").write_text("a file")
    outcome = shot.run()
    assert [(f.kind, str(f.task)) for f in outcome.failures] == [("publish", "list")]
    assert "out/list.txt: Not a directory" in outcome.failures[0].message and outcome.exit_code == 1
    (shot.folder / "out").unlink()
    assert shot.run().evaluated == 0
    assert (shot.folder / "out" / "list.txt").is_file()


def test_a_project_that_was_moved_needs_no_force(shot, monkeypatch, tmp_path_factory):
    """To another machine: what the store has, and what comes out as it is there, is ours, now and without the store."""
    shot.run()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
    assert not shot.run(seed__value=4).failures
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
    shutil.rmtree(shot.folder / "cache")
    assert not shot.run(seed__value=4).failures
    shutil.rmtree(shot.folder / "cache")
    assert not shot.run(seed__value=5).failures


def test_a_ledger_stays_short_and_survives_damage(tmp_path):
    ledger = Ledger()
    for round in range(40):
        ledger.note(tmp_path / "a\n.txt", f"{round:040x}")
    path = ledger_path(tmp_path)
    with path.open("a") as file:
        file.write('\n["a", \n[1, 2, 3]\nnull\n["a\\n.txt", 1]\n"ab"\n"b')
    assert Ledger().digest(tmp_path / "a\n.txt") == f"{39:040x}"
    assert len(path.read_text().split("\n")) < 5 and path.stat().st_mode & 0o077 == 0
    Ledger().note(tmp_path / "b.txt", "b")
    path.chmod(0o666)
    assert Ledger().digest(tmp_path / "b.txt") is None, "others may have written it"
    path.chmod(0o600)
    path.parent.chmod(0o777)
    assert Ledger().digest(tmp_path / "b.txt") is None, "others may have put it there"
    path.parent.chmod(0o700)
    assert Ledger().digest(tmp_path / "b.txt") == "b"


def test_without_a_home_publishing_works(shot, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "tally" / "no" / "folder"))
    (tmp_path / "tally").touch()
    assert not shot.run(frames=[1]).failures
