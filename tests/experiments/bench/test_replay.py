"""A scan that is measured does what a run does; which frames of the paper are measured."""

from dataclasses import replace
from types import SimpleNamespace

import numba
import numpy as np
import pytest

from hairpipe.app.api.source import find_graph
from hairpipe.engine.plan.planner import read_result
from hairpipe.engine.plan.tasks import Task
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench import paper
from hairpipe.graphs.experiments.bench.replay import Replay


def test_replay_equals_the_run_and_stores_nothing(shot):
    replay = Replay(shot.load(), shot.store, "sum")
    replay.prepare(4)
    assert shot.tally() == {"make_seed": 1, "move_seed": 4}
    replayed = [replay.advance(replay.arguments()).number.value for _ in range(4)]
    assert shot.tally() == {"add_up": 4}
    shot.run(to=["sum"])
    assert shot.tally()["add_up"] == 10
    graph = shot.load()
    ran = [read_result(graph, shot.store, Task("sum", frame), "number").value for frame in range(1, 5)]
    assert replayed == ran and len(set(ran)) == 4
    assert np.isfinite(ran).all()


LEARN = '''"""A fold over a file and all frames of somebody else."""
from pathlib import Path
from numeral import Numeral
from tally import numeral
from hairpipe.engine import Reached, Time, node

@node(frames="scan")
def learn(numbers: Reached[Numeral], previous: Numeral | None, time: Time, *, file: Path) -> Numeral:
    """Learn."""
    assert list(numbers) == list(range(1, 11))
    return numeral(numbers[time.frame].value + len(file.read_text()) + (previous.value if previous else 0))
'''


def test_files_and_frames_reached_are_what_they_are_in_a_run(shot):
    (shot.nodes / "learn.py").write_text(LEARN)
    (shot.folder / "words").write_text("abc")
    graph = shot.path.read_text().partition("[sum]")[0]
    shot.path.write_text(graph + '[learn]\ntype = "learn"\nin.numbers = "move"\nfile = "words"\n')
    replay = Replay(shot.load(), shot.store, "learn")
    replay.prepare(10)
    replayed = [replay.advance(replay.arguments()).value for _ in range(2)]
    assert shot.run().exit_code == 0
    assert replayed == [read_result(shot.load(), shot.store, Task("learn", frame)).value for frame in (1, 2)]


DOUBLE = '''"""A fold that is prepared."""
from numeral import Numeral
from tally import numeral, tally
from hairpipe.engine import node

def make_double(seed: Numeral) -> float:
    """Double."""
    tally("make_double")
    return 2.0 * seed.value

@node(frames="scan", prepare=make_double)
def double(seed: Numeral, previous: Numeral | None, prepared: float) -> Numeral:
    """Add up doubles."""
    return numeral(prepared + (previous.value if previous else 0.0))
'''


def test_preparations_are_computed_once(shot):
    (shot.nodes / "double.py").write_text(DOUBLE)
    graph = shot.path.read_text().partition("[move]")[0]
    shot.path.write_text(graph + '[double]\ntype = "double"\nin.seed = "seed"\n')
    replay = Replay(shot.load(), shot.store, "double")
    replay.prepare(3)
    assert [replay.advance(replay.arguments()).value for _ in range(3)] == [6.0, 12.0, 18.0]
    assert shot.tally() == {"make_seed": 1, "make_double": 1}


def test_nodes_without_a_scan_are_refused(shot):
    with pytest.raises(BadInput, match="is not a scan from frame to frame"):
        Replay(shot.load(), shot.store, "move")


def test_ctrl_c_while_it_is_prepared_is_ctrl_c(shot, monkeypatch):
    outcome = replace(shot.run(to=["seed"]), interrupted=True)
    monkeypatch.setattr("hairpipe.graphs.experiments.bench.replay.run", lambda *_: outcome)
    with pytest.raises(KeyboardInterrupt):
        Replay(shot.load(), shot.store, "sum").prepare(4)


class CountingReplay:
    """Stands in for a simulation, whose state is the number of frames before it."""

    def __init__(self, graph, store, name):
        self.frame, self.state = graph.begin, 0

    def prepare(self, frames):
        self.prepared = frames

    def arguments(self):
        return {"groom": SimpleNamespace(offsets=np.array([0, 26, 52]))}

    def advance(self, arguments):
        self.frame, self.state = self.frame + 1, self.state + 1


def test_measured_frames_follow_each_number_of_earlier_ones(monkeypatch):
    measured = []

    def timed_frame(replay):
        replay.advance({})
        measured.append((replay.state, numba.get_num_threads()))
        return 0.1 * replay.state, {"search": replay.state}

    monkeypatch.setattr(paper, "Replay", CountingReplay)
    monkeypatch.setattr(paper, "timed_frame", timed_frame)
    monkeypatch.setattr(paper, "simulated_share", lambda state, strands: state / 100)
    most = numba.get_num_threads()
    scene = find_graph("paper/medium_straight")
    found = list(paper.measure_scene(lambda line: None, scene, None, {}, (20, 5), (1, most)))
    frames = [(frame, threads) for first in (6, 21) for threads in (1, most) for frame in range(first, first + 3)]
    assert measured == frames
    assert [case["first frame"] for case, _ in found] == [6, 6, 21, 21]
    assert [shares["search"] for _, shares in found] == [7, 7, 22, 22]  # of the median frame
    assert [case["simulated [%]"] for case, _ in found] == [8, 8, 23, 23]  # of the last
