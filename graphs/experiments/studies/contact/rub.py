"""A hair is pressed on another one and drawn along it: friction by the lag of a cantilever.

The cantilever bends by one law down and aside. The ratio of lag and deflection of its tip is that of tangential and
normal force, whatever its stiffness and its load.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Air, Collisions, Drag, Scheme, StepControl
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.strands.registry import ModelName
from hairpipe.values import Ends, Groom, Table
from hairpipe.values.table import table_of_rows

LENGTH, SUPPORT, OVER = 0.03, 0.024, 0.003
"""Lengths of the cantilever, and of the hair below it, which is held at both ends; length beyond their contact [m]."""
PRESSED, APART, FIRST = 2e-3, 1e-3, -0.01
"""Way of the root down from contact, its distance before, and its first place along the hair below [m]."""
PRESS, START, RAMP = 0.6, 0.1, 0.25
"""Durations in which the root presses and rests, begins to move, and reaches its speed [s]."""
SLOW = 2e-3
"""Speed at which hair begins to slide [m/s]: at once at a higher one, and the cantilever swings for long."""
LEAST_WAY, LEAST_TIME = 3e-3, 0.16
"""Way and time of steady sliding: joints of several segments, and periods of the cantilever [m], [s]."""
FRAME = 1 / 48
DRAG = 1.0
"""Damping rate of the air [1/s]: at 50 mm/s its force is less than 1 % of the least friction."""


X, Z = np.eye(3)[[0, 2]]
SLIDING = "speed [mm/s]", "tangential over normal force [1]", "error [%]"
STICKING = "share of the limit [1]", "creep in a second [um]"


@dataclass(frozen=True)
class Rub:
    """What rubs, and how it is simulated."""

    collisions: Collisions
    model: ModelName = "rod"
    segments: int = 25
    steps: StepControl = StepControl()  # noqa: RUF009 (frozen)
    scheme: Scheme = Scheme()  # noqa: RUF009


def rub_tables(rub: Rub, speeds: Sequence[float], shares: Sequence[float]) -> tuple[Table, Table]:
    """Tabulate the friction of hair that slides at speeds [m/s], and the creep at shares of the limit of friction."""
    friction = rub.collisions.friction
    found = [sliding_ratio(rub, speed) for speed in speeds]
    sliding = [(1e3 * v, ratio, 100.0 * abs(ratio / friction - 1.0)) for v, ratio in zip(speeds, found, strict=True)]
    sticking = [(share, 1e6 * creep(rub, share)) for share in shares]
    return table_of_rows(SLIDING, sliding), table_of_rows(STICKING, sticking)


def sliding_ratio(rub: Rub, speed: float) -> float:
    """Return the mean ratio of tangential and normal force of a hair that slides steadily at a speed [m/s]."""
    slow = min(speed, SLOW)
    onset = START + 1.5 * rub.collisions.friction * PRESSED / slow
    begun = slow * (onset - 0.5 * START)
    fast = 0.5 * (slow + speed) * RAMP
    keys = [(START, 0.5 * slow * START, slow), (onset, begun, slow), (onset + RAMP, begun + fast, speed)]
    steady = max(LEAST_WAY / speed, LEAST_TIME)
    end = onset + RAMP + steady, begun + fast + speed * steady, speed
    return float(np.mean([ratio for time, ratio in ratios(rub, [*keys, end]) if time > onset + RAMP]))


def creep(rub: Rub, share: float, seconds: float = 1.0) -> float:
    """Return the way that a hair slips in a time, drawn before by a share of the limit of friction [m]."""
    way = share * rub.collisions.friction * PRESSED
    held = [ratio for time, ratio in ratios(rub, [(0.5, way, 0.0), (1.0 + seconds, way, 0.0)]) if time > 1.0]
    return abs(held[-1] - held[0]) * PRESSED


def ratios(rub: Rub, keys: list[tuple[float, float, float]]) -> Iterator[tuple[float, float]]:
    """Yield the ratio of tangential and normal force at every frame after pressing, with its time [s].

    keys  time [s], way [m] and speed [m/s] of the root along the hair below
    """
    height = rub.collisions.thickness.value + APART
    hair = build_hair(lay_crossed(height, rub.segments), Material(), rub.model)
    scene = Scene(0.0, Air(Drag(DRAG)), steps=rub.steps, collisions=rub.collisions, scheme=rub.scheme)
    down = -(PRESSED + APART)
    pressing = [(-PRESS, 0.0, 0.0, 0.0, 0.0), (-PRESS / 3, 0.0, down, 0.0, 0.0), (0.0, 0.0, down, 0.0, 0.0)]
    times, x, y, vx, vy = np.array([*pressing, *((t, way, down, speed, 0.0) for t, way, speed in keys)]).T
    root = CubicHermiteSpline(times, np.stack([x, y, 0 * x], 1), np.stack([vx, vy, 0 * vx], 1))
    state = start(hair, ends_at(root, -PRESS), scene)
    for frame in range(round((times[-1] + PRESS) / FRAME)):
        before = frame * FRAME - PRESS
        now = (frame + 1) * FRAME - PRESS
        ends = ends_at(root, before), ends_at(root, now)
        state = advance_frame(hair, state, ends, (), FRAME, scene, frame * FRAME)
        lag, deflection, _ = hair.layout.axis(state.positions)[-1] - hair.groom.points[-1] - root(now)
        if now > 0.0:
            yield now, -lag / deflection


def lay_crossed(height: float, segments: int, first: float = FIRST, over: float = OVER) -> Groom:
    """Lay a hair along x, and one along z at a height above it, at `first` along x and `over` beyond it [m]."""
    along = np.linspace(0.0, 1.0, segments + 1)[:, None]
    below = np.array([-0.5 * SUPPORT, 0.0, 0.0]) + SUPPORT * along * [1.0, 0.0, 0.0]
    above = np.array([first, height, over - LENGTH]) + LENGTH * along * [0.0, 0.0, 1.0]
    frames = [np.column_stack([x, [0, 1, 0], np.cross(x, [0, 1, 0]), p[0]]) for x, p in ((X, below), (Z, above))]
    return unbound(np.stack([below, above]), np.stack(frames))


def ends_at(root: CubicHermiteSpline, time: float) -> Ends:
    """Hold both ends of the hair below, and move the root of the other one along a way [m], at a time [s]."""
    still = np.eye(3, 4)
    rest = np.zeros((3, 4))
    free = np.full((3, 4), np.nan)
    moved = still.copy()
    rate = rest.copy()
    moved[:, 3], rate[:, 3] = root(time), root(time, 1)
    return Ends(np.stack([still, moved]), np.stack([rest, rate]), np.stack([still, free]), np.stack([rest, free]))
