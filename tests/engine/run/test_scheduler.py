"""Runs: what is evaluated and what is not, counted by the nodes themselves."""

import itertools
import os
import shutil
from collections import Counter

import pytest

from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput

from ..conftest import CHAIN

pytestmark = pytest.mark.usefixtures("kept")

ALL = Counter(make_seed=1, move_seed=10, add_up=10, write_list=1)


def test_second_run_evaluates_nothing_and_seconds_are_those_of_evaluations(shot):
    events, sums = [], Counter()
    first = shot.run(report=events.append)
    assert shot.tally() == ALL
    assert first.evaluated == 22 and first.exit_code == 0
    for event in events:
        if event.kind == "finished":
            sums[event.task.node] += event.seconds
    assert first.seconds == pytest.approx(sums) and set(sums) == {"seed", "move", "sum", "list"}
    second = shot.run()
    assert shot.tally() == Counter() and second.seconds == {}
    assert (second.evaluated, second.cached) == (0, 22)


def test_equal_tasks_are_evaluated_once_whether_they_are_ready_before_or_after(shot):
    """Two slots: `b` waits for `a`, which is being evaluated, and `d` is taken from the queue when `a` has been."""
    values = {"a": 3, "b": 3, "c": 4, "d": 3, "e": 4}
    nodes = "".join(f'[{name}]\ntype = "make_seed"\nvalue = {value}\n' for name, value in values.items())
    shot.write(f"schema = 1\nframes = [1, 1]\nfps = 24\n{nodes}")
    outcome = shot.run()
    assert (outcome.exit_code, outcome.evaluated, outcome.cached, outcome.blocked) == (0, 2, 3, 0)
    assert shot.tally() == {"make_seed": 2}


def test_a_store_that_fails_or_is_a_file_is_named(shot, monkeypatch):
    def fail(store):
        raise PermissionError(13, "Permission denied", "tmp")

    with monkeypatch.context() as patch:
        patch.setattr(Store, "sweep", fail)
        with pytest.raises(BadInput, match=f"{shot.store.root}: the store cannot be used: .*Permission denied"):
            shot.run()
    shutil.rmtree(shot.store.root, ignore_errors=True)
    shot.store.root.write_text("")
    with pytest.raises(BadInput, match="cache: 'seed' has to be computed, and the store cannot be written to"):
        shot.run()


def test_values_are_those_of_the_plain_functions(shot):
    shot.run()
    totals = itertools.accumulate(range(1, 11), lambda total, frame: 3.0 + frame + 0.9 * total, initial=0.0)
    lines = [f"{frame} {total!r}" for frame, total in enumerate(totals)][1:]
    assert (shot.folder / "out" / "list.txt").read_text() == "\n".join(lines)


def test_values_per_frame_make_way_for_the_scan(shot):
    shot.edit("move_seed.py", "seed.value + (0 if still", "__import__('os').nice(0) + (0 if True")
    shot.edit("add_up.py", "number.value + (", "number.value - __import__('os').nice(0) + (")
    shot.run()
    assert (shot.folder / "out" / "list.txt").read_text().splitlines()[0] == f"1 {float(10 - os.nice(0))!r}"


def test_setting_reruns_what_depends_on_it_and_a_longer_range_reuses_old_frames(shot):
    shot.run()
    shot.tally()
    shot.run(sum__warn=99)
    assert shot.tally() == Counter(add_up=10), "same sums: the list stands"
    shot.run(seed__value=4)
    assert shot.tally() == ALL
    shot.run()
    assert shot.tally() == Counter(), "going back finds the old results"
    shot.change("[1, 10]", "[1, 12]")
    shot.run()
    assert shot.tally() == Counter(move_seed=2, add_up=2, write_list=1)


def test_change_from_a_frame_on_keeps_the_frames_before(shot):
    shot.run()
    shot.tally()
    shot.run(move__turn=7)
    # All of `move` is looked at again, but frames 1-6 give what they gave; the sum goes on from the state at frame 4,
    # the nearest one that was kept before frame 7.
    assert shot.tally() == Counter(move_seed=10, add_up=2 + 4, write_list=1)
    changed = shot.results(move__turn=7)
    other = Store(shot.folder / "fresh")
    shot.run(move__turn=7, store=other)
    assert shot.results(other, move__turn=7) == changed


def test_input_file_counts_by_its_bytes(shot):
    (shot.folder / "clip").write_bytes(b"abc")
    (shot.folder / "copy").write_bytes(b"abc")
    shot.run(seed__file="clip")
    shot.tally()
    shot.run(seed__file="copy")
    assert shot.tally() == Counter()
    (shot.folder / "clip").write_bytes(b"xyz")
    shot.run(seed__file="clip")
    assert shot.tally() == Counter(make_seed=1), "three bytes as before: equal values stop the change here"
    (shot.folder / "clip").write_bytes(b"longer")
    shot.run(seed__file="clip")
    assert shot.tally() == ALL


def test_number_of_processes_does_not_show(shot):
    results = {}
    for jobs in (1, 4):
        store = Store(shot.folder / f"cache{jobs}")
        shot.run(store=store, jobs=jobs)
        results[jobs] = shot.results(store)
    assert results[1] == results[4]


def test_selected_frames_of_a_scan_bring_those_before(shot):
    shot.run(frames=[3, 5], to=["sum"])
    assert shot.tally() == Counter(make_seed=1, move_seed=5, add_up=5)
    shot.run(frames=[3, 5], to=["move"])
    assert shot.tally() == Counter()


def test_pair_is_the_current_value_twice_at_the_first_frame(shot):
    shot.write(CHAIN.partition("[sum]")[0] + '[soft]\ntype = "soften"\nin.number = "move"\n')
    shot.run(frames=[1, 2])
    assert shot.tally() == Counter(make_seed=1, move_seed=2, soften=2)
    values = [shot.value(f"soft@{frame}") for frame in (1, 2)]
    assert values == [4.0, 4.5]


def test_warnings_are_given_again_on_hits(shot):
    for _ in range(2):
        shot.run(sum__warn=3)
        assert shot.warned == [("sum@3", "a strand is too short")]


def test_the_path_of_a_graph_need_not_be_text(shot, monkeypatch):
    folder = shot.folder / os.fsdecode(b"caf\xe9")
    monkeypatch.setenv("HAIRPIPE_TRUST", str(folder / "nodes"))
    folder.mkdir()
    shot.nodes, shot.path = shot.nodes.rename(folder / "nodes"), shot.path.rename(folder / "shot.toml")
    assert shot.run().exit_code == 0 and (folder / "out" / "list.txt").exists()
    assert {entry.status for entry in shot.plan().values()} == {"cached"}


def test_scans_begin_before_the_first_frame_and_nothing_else_sees_it(shot):
    """Three frames of pre-roll: the sum has them in it, the list has not."""
    shot.run()
    whole = (shot.folder / "out" / "list.txt").read_text().splitlines()
    shot.tally()
    shot.change("frames = [1, 10]", "frames = [4, 10]\npreroll = 3")
    shot.run()
    assert shot.tally() == Counter(write_list=1)
    assert (shot.folder / "out" / "list.txt").read_text().splitlines() == whole[3:]
    shot.change("preroll = 3", "preroll = 0")
    shot.run()
    assert (shot.folder / "out" / "list.txt").read_text().splitlines()[0] == f"4 {3.0 + 4.0!r}"


def states_of(shot, names) -> list[int]:
    """Frames whose states are in the store."""
    return [frame for frame in range(1, 11) if shot.store.has(names[f"sum@{frame}"]["state"])]


def states_after_each_frame(shot, **settings) -> list[list[int]]:
    """Run a shot; frames whose states are in the store when each frame of the scan is noted."""
    other = Store(shot.folder / "other")
    shot.run(store=other, **settings)
    names = shot.results(other, **settings)
    there = []

    def look(event):
        if event.kind == "finished" and event.task.node == "sum":
            there.append(states_of(shot, names))

    shot.run(report=look, **settings)
    return there


def test_states_are_written_at_checkpoints_and_at_the_last_frame(shot):
    assert states_after_each_frame(shot) == [[]] * 3 + [[4]] * 4 + [[4, 8]] * 2 + [[4, 8, 10]]


def test_states_after_long_evaluations_are_written_and_go_while_the_scan_goes_on(shot):
    shot.edit("tally.py", "IN_WORKER =", WRITE_ALL + "IN_WORKER =")
    there = states_after_each_frame(shot)
    assert there[:4] == [[1], [1, 2], [1, 2, 3], [2, 3, 4]], "a state goes once the result after the next is noted"
    assert there[7:] == [[4, 6, 7, 8], [4, 7, 8, 9], [4, 8, 9, 10]]
    assert states_of(shot, shot.results()) == [4, 8, 10]


WRITE_ALL = """from hairpipe.engine.worker import worker
worker.SAVED_AFTER = 0.0
"""


PAGES = '''"""A fold whose state is a file."""
from typing import Annotated, NamedTuple
from numeral import Numeral
from tally import numeral, tally
from hairpipe.engine import File, Time, Workspace, node
from hairpipe.units import Suffixes

class Written(NamedTuple):
    """The file, and its number of lines."""
    page: Annotated[File, Suffixes((".txt",))]
    lines: Numeral

@node(frames="scan")
def write_on(number: Numeral, previous: File | None, workspace: Workspace, time: Time) -> Written:
    """Add a line for each frame."""
    tally("write_on")
    text = (previous.path.read_text() if previous else "") + f"{time.frame}\\n"
    (workspace / "page").write_text(text)
    return Written(File(workspace / "page"), numeral(float(len(text.splitlines()))))
'''


WRITE = '[write]\ntype = "write_on"\nin.number = "move"\npublish = "out/page.##.txt"\n'


def test_a_thinned_file_of_a_scan_is_published_again(shot):
    (shot.nodes / "write_on.py").write_text(PAGES)
    shot.write(CHAIN.partition("[sum]")[0] + WRITE)
    assert shot.run().published == tuple(str(shot.folder / "out" / f"page.{frame:02}.txt") for frame in range(1, 11))
    shot.tally()
    third = shot.folder / "out" / "page.03.txt"
    assert third.read_text() == "1\n2\n3\n"
    third.unlink()
    assert shot.run().failures == ()
    assert third.read_text() == "1\n2\n3\n" and shot.tally() == {"write_on": 3}
    assert shot.run().evaluated == 0


def test_a_cut_runs_what_depends_on_it_from_there_on(shot):
    shot.edit("add_up.py", "import Time, node", "import Cuts, Time, node")
    shot.edit("add_up.py", "time: Time, *", "time: Time, cuts: Cuts, *")
    shot.edit("add_up.py", "(0.9 * previous.total if previous else 0.0)", "(0.0 if cuts or not previous else 0.9)")
    shot.run()
    shot.tally()
    shot.change("fps = 24", "fps = 24\ncuts = [9, 70]")
    plan = shot.plan()
    found = [plan[name] for name in ("move@9", "sum@8", "sum@9", "sum@10")]
    assert [entry.status for entry in found] == ["cached", "cached", "run", "depends"]
    assert found[2].reason == "cuts absent -> [9]"
    shot.run()
    assert shot.tally() == Counter(add_up=2, write_list=1)
