"""Nodes that fail, a full disk, an interrupted run: one message each, and nothing computed is lost."""

import errno
import signal
from collections import Counter

import pytest

from hairpipe.engine.store.values import is_full

from .conftest import wait_for

WRONG = """
[wrong]
type = "go_wrong"
in.number = "move"
[after]
type = "soften"
in.number = "wrong"
"""


@pytest.fixture
def wrong(shot):
    """A shot with a branch that fails at frame 3."""
    shot.path.write_text(shot.path.read_text().replace("[1, 10]", "[1, 5]") + WRONG)
    return shot


@pytest.mark.parametrize(
    ("how", "kind", "code", "reported"),
    [
        ("raise", "node", 1, "wrong@3: ZeroDivisionError: no strands left"),
        ("input", "input", 2, "wrong@3: walk.bvh:7: not a clip"),
        ("kill", "crash", 1, "wrong@3: the worker process was ended by SIGKILL"),
        ("type", "node", 1, "wrong@3: TypeError: returned a float, declared Numeral"),
    ],
)
def test_other_branches_finish_with_keep_going(wrong, how, kind, code, reported):
    outcome = wrong.run(keep_going=True, wrong__how=how)
    assert [(f.kind, str(f)[: len(reported)]) for f in outcome.failures] == [(kind, reported)]
    assert outcome.exit_code == code
    assert outcome.blocked == 2, "frames 3 and 4 of what follows"
    counts = wrong.tally()
    assert (counts["add_up"], counts["write_list"], counts["go_wrong"], counts["soften"]) == (5, 1, 5, 3)
    assert (wrong.folder / "out" / "list.txt").exists()


def test_plain_tuple_is_not_a_named_one(shot):
    shot.edit("add_up.py", "return Added(", "return (")
    (failure,) = shot.run().failures
    assert str(failure) == "sum@1: TypeError: returned a tuple, declared Added"


def test_without_keep_going_the_run_stops_and_keeps_what_it_has(wrong):
    outcome = wrong.run(jobs=1)
    (failure,) = outcome.failures
    assert outcome.exit_code == 1 and outcome.blocked > 0
    assert "go_wrong.py" in failure.traceback and "go_wrong.py" not in failure.message
    done = wrong.tally()
    wrong.edit("go_wrong.py", "time.frame == at", "False")
    assert wrong.run().exit_code == 0
    total = done + wrong.tally()
    assert (total["make_seed"], total["move_seed"], total["add_up"]) == (1, 5, 5)


@pytest.mark.parametrize("file", ["numeral.py", "move_seed.py"])
def test_results_of_code_edited_during_the_run_are_not_kept(shot, file):
    """Keys are made of the code as it was, and nodes import late: within their functions, and once they are needed."""
    text = (shot.nodes / file).read_text()

    def edit(event):
        if event.kind == "begun":
            shot.edit(file, "value", "value")

    outcome = shot.run(report=edit, keep_going=True)
    places = {failure.message for failure in outcome.failures}
    assert places == {f"{shot.nodes / file}: changed during the run (run again)"} and outcome.exit_code == 2
    (shot.nodes / file).write_text(text)
    shot.tally()
    assert shot.run().exit_code == 0
    assert shot.tally()["move_seed"] == 10


def test_full_disk_stops_everything_with_one_message(wrong):
    outcome = wrong.run(keep_going=True, wrong__how="full", jobs=1)
    (failure,) = outcome.failures
    assert failure.kind == "disk" and "No space left" in failure.message and outcome.exit_code == 1


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_known_by_what_hdf5_says_of_it(number):
    assert is_full(OSError(f"Can't write data (file write failed: errno = {number}, error message = '...')"))


def test_full_disk_leaves_a_store_that_continues(shot, monkeypatch):
    """The third object does not fit; with room again, the rest is computed and equals an undisturbed run."""
    shot.edit("tally.py", "if IN_WORKER and", FULL_DISK + "if IN_WORKER and")
    monkeypatch.setenv("TOY_FULL_AFTER", "3")
    outcome = shot.run(jobs=1)
    assert {failure.kind for failure in outcome.failures} == {"disk"}
    assert list((shot.store.root / "tmp").iterdir()) == []
    done = shot.tally()
    monkeypatch.delenv("TOY_FULL_AFTER")
    assert shot.run().exit_code == 0
    assert (done + shot.tally())["add_up"] <= 11


FULL_DISK = """
if IN_WORKER and "TOY_FULL_AFTER" in os.environ:
    from hairpipe.engine.store import atomic

    flush, left = atomic.flush, [int(os.environ["TOY_FULL_AFTER"])]

    def full(path):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(28, "No space left on device", str(path))
        flush(path)

    atomic.flush = full
"""


def test_ctrl_c_stops_at_once_and_keeps_results(wrong):
    text = wrong.path.read_text()
    wrong.path.write_text(text.replace('type = "go_wrong"', 'type = "go_wrong"\nhow = "slow"\nat = 5'))
    process = wrong.start(jobs=2)
    wait_for(lambda: wrong.has_called("go_wrong 5") and (wrong.folder / "out" / "list.txt").exists())
    wait_for(lambda: len(list(wrong.store.root.glob("actions/??/*"))) == 1 + 5 + 5 + 1 + 4 + 4)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=10)
    assert process.returncode == 130
    assert errors == b"", "no traceback, of nobody"
    assert b'"interrupted": true' in output
    wrong.tally()
    wrong.edit("go_wrong.py", '"slow":', '"never":')
    wrong.run()
    assert wrong.tally() == Counter(go_wrong=5, soften=1), "the first four frames stand"
