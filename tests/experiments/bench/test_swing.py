"""The comparison of solvers, on a pendulum that is known in closed form."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench import swing
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.report import Report
from hairpipe.graphs.experiments.peers import registry
from hairpipe.graphs.experiments.peers.hanging import FRAME, Hanging, Peer
from hairpipe.graphs.experiments.peers.registry import Adapter, installed
from hairpipe.graphs.experiments.studies.theory.beam_modes import bending_frequencies
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica

SCENES = Hanging(0.3, 60.0, seconds=0.1), replace(swing.CANTILEVER, seconds=0.1), swing.RINGING


class Known:
    """A strand that rests at the tip of the elastica, and rings at the frequency of a beam; it is 1 % too long."""

    def __init__(self, scene, strands, faster=1.0):
        fibre = scene.material
        self.count, self.scene = 0, scene
        self.rate = 2 * np.pi * faster * bending_frequencies(1, scene.length, fibre.bending, fibre.line_density)[0]
        weight = fibre.line_density * scene.gravity * scene.length**3 / fibre.bending
        self.rest = scene.length * np.array([*bend_elastica(weight).tip, 0.0])

    def advance(self):
        self.count += 1

    def points(self):
        if self.scene is SCENES[1]:
            return np.stack([np.zeros(3), self.rest])
        if self.scene is SCENES[2]:
            height = 1e-3 * (np.cos(self.rate * self.count * FRAME) - 1.0)
            return np.array([[0.0, 0.0, 0.0], [self.scene.length, height, 0.0]])
        return np.stack([np.zeros(3), self.scene.length * self.scene.direction * (1.01 if self.count else 1.0)])


def adapter(faster):
    peer = Peer("Known 1.0", "exact", 1, 3, 7, lambda scene, strands: Known(scene, strands, faster))
    return Adapter("hairpipe", lambda: [peer], lambda scene: Known(scene, 1))


def test_a_solver_is_compared_with_theory_and_with_converged_runs():
    echoed = []
    report = swing.measure_swing(echoed.append, {"known": adapter(1.02)}, SCENES, timed=2)
    (case,) = report.tables["peers"]
    assert (case["solver"], case["steps a frame"], case["strands"]) == ("Known 1.0", 3, 7)
    assert case["error to known [%]"] == 0.0 and case["stretch [%]"] == pytest.approx(1.0)
    assert case["cantilever [%]"] == pytest.approx(0.0, abs=1e-9)
    assert case["frequency [%]"] == pytest.approx(2.0, abs=0.05)
    assert case["wall [us]"] > 0.0 and "converged" not in report.tables
    assert echoed == ["a converged swing by known", "Known 1.0, 1 segments, 3 steps a frame: exact"]


def test_converged_runs_of_two_solvers_are_compared_with_each_other():
    report = swing.measure_swing(lambda line: None, {"a": adapter(1.0), "b": adapter(1.0)}, SCENES, timed=1)
    assert report.tables["converged"] == [{"a": "a", "b": "b", "difference [%]": 0.0}]


def test_an_absent_solver_is_one_line_and_an_unknown_one_is_refused():
    echoed = []
    absent = {"absent": adapter(1.0)._replace(library="no_such_library"), "known": adapter(1.0)}
    assert [*installed(None, echoed.append, absent)] == ["known"]
    assert echoed == ["absent is not installed and is left out; all are in the extra `peers`"]
    with pytest.raises(BadInput, match="unknown solver 'x'"):
        installed(["x"], echoed.append)


def test_the_command_takes_solvers_by_name(monkeypatch, bench):
    given = []
    machine = Machine("A Processor", 2, {"numba": "1.2"})
    monkeypatch.setattr(
        swing, "measure_swing", lambda echo, solvers: given.extend(solvers) or Report("swing", machine, {"peers": []})
    )
    assert json.loads(bench("swing --peers hairpipe --json").stdout)["tables"] == {"peers": []}
    assert given == ["hairpipe"]


@pytest.mark.kernels
def test_a_rod_of_ours_has_the_frequency_and_the_tip_of_theory():
    peer = registry.ADAPTERS["hairpipe"].peers()[0]
    scenes = swing.CANTILEVER, swing.RINGING
    sag, wave = (swing.follow(peer.lay(scene, 1), scene) for scene in scenes)
    assert swing.sag_error(sag, scenes[0]) < 0.1 and abs(swing.frequency_error(wave, scenes[1])) < 0.3


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["pyelastica", "pypbd", "newton"])
def test_another_solver_starts_as_ours_does(name):
    pytest.importorskip(registry.ADAPTERS[name].library)
    scene = Hanging(0.1, 90.0)
    for peer in registry.ADAPTERS[name].peers()[:1]:
        points = peer.lay(scene, 1).points()
        assert points[-1] == pytest.approx([0.1, 0.0, 0.0], abs=1e-6)
