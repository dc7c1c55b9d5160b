"""Models and members side by side: the same measurements and the same number of evaluations as one after another."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hairpipe.app.api.shot import Shot, Task, load
from hairpipe.app.tune.measured import Chaos, Measured, Tolerance
from hairpipe.app.tune.sampling import Sample
from hairpipe.app.tune.study import Interrupted, Request, Study
from hairpipe.app.tune.tuning import measured_singles
from hairpipe.values.simplification import Simplification

from ...engine.cluster import Cluster

pytestmark = pytest.mark.slow

MODEL = '''"""Hair that sways; a difference of two grooms grows until it is as large as the sway."""

import os
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hairpipe.values import Groom, Strands
from hairpipe.values.value import value
from hairpipe.engine import Time, node


@value
class Swaying:
    """Frames since the start, and points, which distinguish models.

    count   (1,)
    points  [m], (P, 3)
    """

    count: np.ndarray
    points: np.ndarray


class Sway(NamedTuple):
    """Strands to look at, and the state the next frame starts from."""

    strands: Strands
    state: Swaying


@dataclass(frozen=True)
class Steps:
    """Steps of a frame.

    longest  step
    """

    longest: float = 1 / 24


@node(frames="scan")
def sway_hair(
    groom: Groom, previous: Swaying | None, time: Time, *, growth: float = 1.7, fails: int = 0, steps: Steps = Steps()
) -> Sway:
    """Hair that sways.

    growth  factor of a difference in a frame
    fails   frame
    steps   in time
    """
    count = 0.0 if previous is None else float(previous.count[0]) + 1.0
    if fails and time.frame >= fails:
        note("failed", time.frame)
        raise ValueError("hair is torn")
    grown = 0.01 * np.sin(groom.points[:, ::2] / 0.01 * growth**count + steps.longest)
    points = groom.points + [0.0, 0.01, 0.0] * np.array(steps.longest)
    points[:, ::2] += grown * min(count, 1.0)
    note(f"{growth}/{steps.longest:.3f}", time.frame)
    strands = Strands(points, np.zeros(points.shape, np.float32), groom.offsets, 8e-5)
    return Sway(strands, Swaying(np.array([count]), points))


def note(what, frame):
    """Add a line to the tally."""
    with open(os.environ["SWAY_TALLY"], "a") as tally:
        tally.write(f"{what} {frame}\\n")
'''
SCENE = """schema = 1
frames = [1, 8]
fps = 24
[groom]
type = "make_strands"
strands = 4
length = 0.1
segments = 4
spacing = [0.0, 0.0, 0.02]
[hair]
type = "sway_hair"
in.groom = "groom"
steps = { longest = 0.041666 }
"""
TOLERANCE = Tolerance(2e-3, "m")
SAMPLE = Sample(4, 2, 0, 1, 5, 8)
TIP = 4e-4
SLOW, QUICK = (Simplification("growth", n, f"growth {g}", (("hair.growth", g),)) for n, g in ((1, 1.65), (2, 1.75)))
TORN = Simplification("growth", 3, "torn", (("hair.fails", 3),))
WRONG = Simplification("growth", 4, "wrong", (("hair.unknown", 3),))
MODELS = ([], [SLOW], [TORN], [QUICK], [WRONG])


class Scene:
    """A scene in a folder of its own.

    evaluated  number of evaluations of all runs, `most` of which are followed by an interruption
    side       settings and frames of the simulations that ran at the same time as another
    """

    def __init__(self, folder: Path) -> None:
        self.path, self.tally = folder / "scene.toml", folder / "tally"
        (folder / "nodes").mkdir()
        (folder / "nodes/sway_hair.py").write_text(MODEL)
        self.path.write_text(SCENE)
        self.most: int | None = None
        self.evaluated, self.side = 0, []

    def run(self, engine):
        """Make what carries out runs."""

        def run(text, shot: Shot, nodes, frames, *, timed=True):
            running: dict[Task, tuple[float, float, int]] = {}

            def watch(event):
                self.evaluated += event.kind == "finished"
                if self.evaluated == self.most:
                    raise KeyboardInterrupt
                node = shot.nodes[event.task.node] if event.task else None
                if node is not None and node.type.name == "sway_hair":
                    run = node.settings["growth"], node.settings["steps"]["longest"], event.task.frame
                    running.pop(event.task, None)
                    if event.kind == "started":
                        running[event.task] = run
                        self.side += running.values() if len(running) > 1 else ()

            options: dict[str, Any] = {"jobs": 1} if timed else engine
            return shot.run(frames, to=nodes, keep_going=True, progress=watch, **options).outcome

        return run

    def measured(self, cache: str, tip=None, **engine) -> tuple[Measured | Chaos, list[Measured], int]:
        """Measure all models, with a store and an engine; returns measurements without times, and evaluations."""
        self.evaluated, self.side = 0, []
        self.tally.unlink(missing_ok=True)
        with load(self.path, cache=self.path.parent / cache).keeping_workers() as shot:
            study = Study(Request(shot, "hair", TOLERANCE, self.run(engine)), SAMPLE, 4, tip)
            reference = study.converged()
            found = study.confirm_all(MODELS if tip is None else MODELS[:3])
        if isinstance(reference, Measured):
            reference = replace(reference, seconds=0.0)
        return reference, [replace(one, seconds=min(one.seconds, 0.0)) for one in found], self.evaluated

    @property
    def calls(self) -> Counter[str]:
        """Count the calls of the node that simulates, by model and frame, in all processes."""
        return Counter(self.tally.read_text().splitlines())


@pytest.fixture
def scene(tmp_path, monkeypatch) -> Scene:
    return prepared(tmp_path, monkeypatch)


def prepared(folder: Path, monkeypatch) -> Scene:
    """Make a scene, and allow its code to run."""
    made = Scene(folder)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(folder / "nodes"))
    monkeypatch.setenv("SWAY_TALLY", str(made.tally))
    return made


STEP, FINE = 0.041666, 0.020833


def test_models_are_timed_one_at_a_time_and_all_else_runs_side_by_side(scene):
    alone = scene.measured("alone", jobs=1, scans=1)
    calls = scene.calls
    assert not scene.side
    found = scene.measured("two", jobs=2, scans=2)
    assert found == alone and scene.calls == calls
    models = {(growth, frame) for growth, step, frame in scene.side if step == STEP}
    assert {growth for growth, _ in models} >= {1.65, 1.75}
    assert {frame for _, frame in models} <= {*range(1, 5)}, "none of the measured frames"
    assert FINE in {step for _, step, _ in scene.side}, "the reference"
    reference, models, _ = found
    assert not reference.fault
    assert [one.fault for one in models[:4]] == ["", "", "ValueError: hair is torn", ""]
    assert "unknown" in models[4].fault and calls["failed 3"] == 1


def test_levels_are_measured_until_the_time_is_spent(scene):
    coarse = [
        Simplification(axis, level, "", (("hair.growth", 1.5),)) for axis, level in (("a", 1), ("b", 2), ("c", 1))
    ]
    with load(scene.path, cache=scene.path.parent / "cache").keeping_workers() as shot:
        study = Study(Request(shot, "hair", TOLERANCE, scene.run({"jobs": 1})), SAMPLE, 4)
        study.measure_all([[]])[0]
        study.limit = 1e-6
        assert study.has_time() is False and measured_singles(study, coarse) == {}
        again = Study(study.request, SAMPLE, 4)
        again.limit = 1e-6
        assert list(measured_singles(again, coarse)) == [coarse[0], coarse[2]] and again.stopped


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Measurements of chaotic hair one after another, and the calls."""
    with pytest.MonkeyPatch.context() as patch:
        made = prepared(tmp_path_factory.mktemp("alone"), patch)
        return made.measured("cache", TIP, jobs=1, scans=1), made.calls


def test_members_run_side_by_side_and_an_interrupted_study_evaluates_nothing_again(scene, alone):
    scene.most = 50
    with pytest.raises(Interrupted):
        scene.measured("cache", TIP, jobs=2, scans=2)
    scene.most = None
    chaos, models, rest = scene.measured("cache", TIP, jobs=2, scans=2)
    assert (chaos, models, 50 + rest) == alone[0]
    assert isinstance(chaos, Chaos) and chaos.chaotic
    assert [one.climate is not None for one in models] == [True, True, False]
    assert (1.65, STEP) in {(growth, step) for growth, step, frame in scene.side if frame in SAMPLE.frames}


def test_a_cluster_measures_what_one_machine_measures(scene, alone):
    pytest.importorskip("distributed", reason="distributed is not installed (the extra `dask`)")
    (scene.path.parent / "cluster").mkdir()
    cluster = Cluster(scene.path.parent / "cluster")
    try:
        found = scene.measured("cache", TIP, scheduler=cluster.address, insecure=True)
    finally:
        cluster.close()
    assert (found, scene.calls) == alone
    assert scene.calls["1.7/0.021 8"] == 4 and scene.calls["1.65/0.042 8"] == 3, "members of reference and model"
    assert (1.7, FINE) in {side[:2] for side in scene.side}
