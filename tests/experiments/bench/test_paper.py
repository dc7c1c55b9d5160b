"""The paper's scenes: which frames are measured."""

from types import SimpleNamespace

import numba
import numpy as np

from hairpipe.app.api.source import find_graph
from hairpipe.graphs.experiments.bench import paper


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
