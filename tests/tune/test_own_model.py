"""A model of hair of one's own is tuned, timed and put on the chart, with nothing but its own files."""

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from hairpipe.api.shot import load
from hairpipe.cli.entry import commands
from hairpipe.errors import BadInput
from hairpipe.tune.simplifications import simplifications

MODEL = '''"""Hair as a pendulum a strand: all of its points swing about the root by one angle."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from hairpipe.data import Groom, Strands
from hairpipe.data.value import value
from hairpipe.graph import Time, node
from hairpipe.units import Gt, Seconds


@value
class Angle:
    """Where hair is.

    angle  from the groom [rad]
    rate   of it [rad/s]
    """

    angle: float
    rate: float


class Swing(NamedTuple):
    """Strands to look at, and the state the next frame starts from."""

    strands: Strands
    state: Angle


@dataclass(frozen=True)
class Steps:
    """How a frame is cut into steps.

    longest  step
    """

    longest: Annotated[Seconds, Gt(0)] = 1 / 96


@dataclass(frozen=True)
class Wobble:
    """A term that costs time and changes nearly nothing.

    rounds  of it in each step
    """

    rounds: int = 2000


@node(frames="scan", tuning="swing_tuning")
def swing_hair(
    groom: Groom, previous: Angle | None, time: Time, *, steps: Steps = Steps(), wobble: Wobble | None = None
) -> Swing:
    """Hair that swings.

    steps   in time
    wobble  of each step; without, there is none
    """
    found = previous or Angle(0.3, 0.0)
    count = int(np.ceil(time.dt / steps.longest - 1e-9)) if previous else 0
    angle, rate, h = found.angle, found.rate, time.dt / max(count, 1)
    for _ in range(count):
        for turn in range(wobble.rounds if wobble else 0):
            rate += 1e-12 * np.sin(turn)
        rate -= h * 40.0 * np.sin(angle)
        angle += h * rate
    roots = np.repeat(groom.points[groom.offsets[:-1]], np.diff(groom.offsets), axis=0)
    c, s = np.cos(angle), np.sin(angle)
    points = roots + (groom.points - roots) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    strands = Strands(points, np.zeros(points.shape, np.float32), groom.offsets, 8e-5)
    return Swing(strands, Angle(angle, rate))
'''
TUNING = '''"""What can be left out of hair that swings."""

from hairpipe.simplification import Simplification


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
[hair]
type = "swing_hair"
in.groom = "groom"
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
    (tmp_path / "nodes/swing_hair.py").write_text(MODEL)
    (tmp_path / "nodes/swing_tuning.py").write_text(TUNING)
    (tmp_path / "scene.toml").write_text(SCENE)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    return tmp_path / "scene.toml"


def test_it_is_tuned_by_what_it_lists_and_by_what_all_models_have(scene):
    command = f"tune {scene} --node hair --tolerance 5mm --json --cache {scene.parent}/cache".split()
    result = CliRunner().invoke(commands, command, prog_name="hairpipe")
    found = json.loads(result.stdout)
    assert {part["axis"] for part in found["simplifications"]} == {"wobble", "segments", "steps"}
    assert not any(part["fault"] for part in found["simplifications"]) and not found["full"]["fault"]
    assert "no wobble" in found["chosen"]["left_out"] and "[hair.wobble]" not in found["fragment"]
    assert found["chosen"]["seconds"] < 0.9 * found["full"]["seconds"]


def test_it_is_timed_and_put_on_the_chart(scene):
    scene.write_text(SCENE + CHART)
    shot = load(scene, cache=scene.parent / "cache")
    assert shot.run(jobs=1).ok and (scene.parent / "front.png").stat().st_size > 1000
    table = shot.get("variants")
    costly, cheap = table["seconds per frame"]
    assert costly > 1.2 * cheap > 0.0
    assert list(table["on the front"])[1] == 1 and math.isfinite(table["strand error [% of length]"][1])


def test_what_is_no_model_is_refused_and_models_are_named(scene):
    with pytest.raises(BadInput, match=r"'groom' is a make_strands, which does not simulate hair \(--node hair\)"):
        simplifications(load(scene).graph, "groom")
