"""A model of hair of one's own gets shots, cuts, export, tuning and the chart with nothing but its own files."""

import json
import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from hairpipe.app.api.shot import load
from hairpipe.app.cli.entry import commands
from hairpipe.app.tune.simplifications import simplifications
from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.lint import lint

from ...pages import HOME

pytestmark = pytest.mark.usefixtures("kept_workers")
MODEL = '''"""Hair that lags: every point approaches the place to which its root would take it rigidly."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from hairpipe.values import Ends, Groom, Strands
from hairpipe.values.value import value
from hairpipe.engine import Cuts, Pair, Time, node
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.shot.shot import rigid_over_cut
from hairpipe.shot.shot import Frame, next_state
from hairpipe.units import Gt, Seconds

RATE = 8.0


@value
class Lagging:
    """Points of all strands.

    points      [m], (P, 3)
    velocities  [m/s], (P, 3)
    """

    points: np.ndarray
    velocities: np.ndarray


class Lag(NamedTuple):
    """Strands to look at, and the state the next frame starts from."""

    strands: Strands
    state: Lagging


@dataclass(frozen=True)
class Steps:
    """Steps of a frame.

    longest  step
    """

    longest: Annotated[Seconds, Gt(0)] = 1 / 96


@dataclass(frozen=True)
class Wobble:
    """A term that costs time and changes nearly nothing.

    rounds  number of evaluations in each step
    """

    rounds: int = 2000


@dataclass(frozen=True)
class LagSimulation:
    """A groom and its settings."""

    groom: Groom
    steps: Steps
    wobble: Wobble | None

    def rigid(self, motions, points):
        """Move points with their roots."""
        each = np.repeat(motions, np.diff(self.groom.offsets), axis=0)
        return np.einsum("pij,pj->pi", each[:, :, :3], points) + each[:, :, 3]

    def goal(self, driver):
        """Return the places to which roots would take all points."""
        return self.rigid(motion_of_roots(driver, self.groom)[0], self.groom.points)

    def start(self, frame):
        points = self.goal(frame.drivers[1])
        return Lagging(points, np.zeros_like(points))

    def advance(self, state, frame):
        count = int(np.ceil(frame.frame_dt / self.steps.longest - 1e-9))
        before, after, points = self.goal(frame.drivers[0]), self.goal(frame.drivers[1]), state.points
        h, noise = RATE * frame.frame_dt / count, 0.0
        for step in range(count):
            for turn in range(self.wobble.rounds if self.wobble else 0):
                noise += 1e-12 * np.sin(turn)
            goal = before + (step + 1) / count * (after - before)
            points = (points + h * goal + noise) / (1.0 + h)
        return Lagging(points, (points - state.points) / frame.frame_dt)

    def move_over_cut(self, state, drivers):
        moved, turned = rigid_over_cut(drivers, self.groom)
        return Lagging(self.rigid(moved, state.points), self.rigid(turned, state.velocities))


@node(frames="scan", tuning="lag_tuning")
def lag_hair(
    groom: Groom,
    ends: Pair[Ends],
    previous: Lagging | None,
    time: Time,
    cuts: Cuts,
    *,
    steps: Steps = Steps(),
    wobble: Wobble | None = None,
) -> Lag:
    """Hair that lags.

    steps   in time
    wobble  of each step; without, there is none
    """
    frame = Frame(ends, (), (), (time.frame - 1) * time.dt, time.dt, time.frame in cuts)
    state = next_state(LagSimulation(groom, steps, wobble), previous, frame)
    return Lag(Strands(state.points, state.velocities.astype(np.float32), groom.offsets, 8e-5), state)
'''
TUNING = '''"""What can be left out of hair that lags."""

from hairpipe.values.simplification import Simplification


def simplifications(settings, sockets, dt):
    """List it."""
    if settings["wobble"] is not None:
        yield Simplification("wobble", 1, "no wobble", drops=("wobble",))
'''
SCENE = """schema = 1
frames = [1, 12]
fps = 24
[groom]
type = "make_strands"
strands = 8
length = 0.1
segments = 6
spacing = [0.0, 0.0, 0.02]
[ends]
type = "drive_ends"
in.groom = "groom"
at = 1
roots = { times = [0.0, 0.25, 0.5], move = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.05, 0.0]] }
[hair]
type = "lag_hair"
in = { groom = "groom", ends = "ends" }
[hair.wobble]
"""
CHART = """
[plain]
like = "hair"
without = ["wobble"]
[error]
type = "measure_fidelity"
in = { hair = "plain", truth = "hair" }
[none]
like = "error"
in.hair = "hair"
[plain_cost]
type = "measure_cost"
in.nodes = "plain"
[cost]
type = "measure_cost"
in.nodes = "hair"
[variants]
type = "collect_variants"
in = { errors = ["none", "error"], costs = ["cost", "plain_cost"] }
cases = ["with wobble", "without"]
[chart]
type = "plot_front"
in.table = "variants"
publish = "front.png"
"""


@pytest.fixture
def scene(tmp_path, monkeypatch) -> Path:
    (tmp_path / "nodes").mkdir()
    (tmp_path / "nodes/lag_hair.py").write_text(MODEL)
    (tmp_path / "nodes/lag_tuning.py").write_text(TUNING)
    (tmp_path / "scene.toml").write_text(SCENE)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    return tmp_path / "scene.toml"


@pytest.mark.slow
def test_it_is_tuned_by_what_it_lists_and_by_what_all_models_have(scene):
    command = f"tune {scene} --node hair --tolerance 5mm --json --cache {scene.parent}/cache".split()
    result = CliRunner().invoke(commands, command, prog_name="hairpipe")
    found = json.loads(result.stdout)
    assert {part["axis"] for part in found["simplifications"]} == {"wobble", "segments", "steps"}
    assert not any(part["fault"] for part in found["simplifications"]) and not found["full"]["fault"]
    assert "no wobble" in found["chosen"]["left_out"] and "[hair.wobble]" not in found["fragment"]
    assert found["chosen"]["seconds"] < 0.9 * found["full"]["seconds"]


@pytest.mark.slow
def test_it_is_timed_and_put_on_the_chart(scene):
    for name in ("collect_variants", "plot_front"):
        shutil.copy(HOME / f"graphs/experiments/nodes/{name}.py", scene.parent / "nodes")
    scene.write_text(SCENE + CHART)
    shot = load(scene, cache=scene.parent / "cache")
    assert shot.run(jobs=1).ok and (scene.parent / "front.png").stat().st_size > 1000
    table = shot.get("variants")
    costly, cheap = table["seconds per frame"]
    assert costly > 1.2 * cheap > 0.0
    assert list(table["on the front"])[1] == 1 and math.isfinite(table["strand error [% of length]"][1])


SHOT = """
[usd]
type = "export_usd"
in = { hair = "hair", groom = "groom" }
publish = "shot.usdc"
[picture]
type = "preview"
in.hair = "hair"
width = 64
height = 64
publish = "frames/shot.####.png"
"""
STEADY = 'roots = { ease = "linear", times = [-1.0, 1.0], move = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]] }'
LEAP = (
    'roots = { ease = "linear", times = [-1.0, 0.23, 0.2301, 1.0], '
    "move = [[-1.0, 0.0, 0.0], [0.23, 0.0, 0.0], [5.2301, 0.0, 0.0], [6.0, 0.0, 0.0]] }"
)


def shown(scene: Path, roots: str, header: str = "", nodes: str = "") -> dict:
    """Run the shot, without the term that costs time, under other roots; return the strands of each frame."""
    text = re.sub("^roots = .*$", roots, SCENE, flags=re.MULTILINE).replace("[hair.wobble]", "")
    scene.write_text(text.replace("schema = 1", f"schema = 1\n{header}") + nodes)
    shot = load(scene, cache=scene.parent / "cache")
    assert shot.run(jobs=1).ok
    return shot.get("hair")


@pytest.mark.slow
def test_it_goes_over_cuts_with_its_roots_and_is_exported_and_drawn(scene):
    steady, thrown, cut = shown(scene, STEADY), shown(scene, LEAP), shown(scene, LEAP, "cuts = [7]", SHOT)
    np.testing.assert_allclose(cut[6].points, steady[6].points, atol=1e-8)
    for frame in (7, 12):
        np.testing.assert_allclose(cut[frame].points - [5.0, 0.0, 0.0], steady[frame].points, atol=1e-6)
        assert np.abs(thrown[frame].points - cut[frame].points).max() > 0.5
    assert lint(scene.parent / "shot.usdc") == []
    assert (scene.parent / "frames/shot.0012.png").stat().st_size > 1000


@pytest.mark.slow
def test_it_is_in_motion_at_the_first_frame_after_a_pre_roll(scene):
    begun, led_in = shown(scene, STEADY), shown(scene, STEADY, "preroll = 12")
    np.testing.assert_array_equal(begun[1].velocities, 0.0)
    np.testing.assert_allclose(led_in[1].velocities[:, 0], 1.0, atol=0.05)


def test_other_nodes_are_refused_and_models_named(scene):
    with pytest.raises(BadInput, match=r"'groom' is a make_strands, which does not simulate hair \(--node hair\)"):
        simplifications(load(scene).graph, "groom")
