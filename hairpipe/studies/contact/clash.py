"""A bar that is driven through a tuft and back: the steps and speeds at which contact fails."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hairpipe.data import Table
from hairpipe.data.hair import HairState
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.sim.advance import advance_frame, start
from hairpipe.sim.build import bodies_of
from hairpipe.sim.hair_model import HairModel, build_hair
from hairpipe.sim.material import Material
from hairpipe.sim.settings import Scene, StepControl
from hairpipe.sim.state import State
from hairpipe.studies.contact.bar import LENGTH, SEGMENTS, axis_at, bar_at, depth, passed_through, roots_at, tuft

FRAME = 1 / 24
STRETCHED = 0.1
FLUNG, FLUNG_LEAST = 2.0, 1.0
"""A point is flung that is faster than so many times the fastest of the converged run, and so much more [m/s].

Not than the bar: ends of hair that slides off it whip, and do so at six times its speed.
"""
COLUMNS = (
    "speed",
    "step [s]",
    "steps",
    "deepest [mm]",
    "through the bar [strands]",
    "stretch [%]",
    "fastest [m/s]",
    "failed",
)


@dataclass(eq=False)
class Worst:
    """The worst of a run so far.

    deepest point [m]; stretch of a segment; fastest point [m/s]; through: strands that went through the bar, (S,) bool
    """

    through: np.ndarray
    steps: int = 0
    deepest: float = 0.0
    stretch: float = 0.0
    fastest: float = 0.0
    finite: bool = field(default=True)


def clash_table(
    truth: Table | None, scene: Scene, bar: bool, speeds: Sequence[float], rates: Sequence[int], seconds: float
) -> Table:
    """Tabulate what becomes of the tuft at every speed [m/s] and every number of steps a second.

    truth  such a table of converged runs, with all these speeds, or BadInput; None: this is one
    scene  without its step control: steps are of one length
    bar    whether there is one; else the roots alone move
    """
    hair, rows, known = build_hair(tuft(), Material()), [], fastest_of(truth)
    if missing := sorted({f"{speed:g} m/s" for speed in speeds} - set(known)) if known else []:
        raise BadInput(f"the converged run has no {missing[0]}", right=f"one of {', '.join(known)}")
    for speed in speeds:
        possible = FLUNG * known.get(f"{speed:g} m/s", np.inf) + FLUNG_LEAST
        for rate in rates:
            steps = StepControl(1.0 / rate, np.inf, np.inf, crossings=np.inf)
            worst = meet(hair, replace(scene, steps=steps), bar, speed, seconds)
            values = 1e3 * worst.deepest, int(worst.through.sum()), 100 * worst.stretch, worst.fastest
            rows.append((f"{speed:g} m/s", 1.0 / rate, worst.steps, *values, signs(worst, possible)))
    return table_of_rows(COLUMNS, rows)


def fastest_of(truth: Table | None) -> dict[str, float]:
    """Return how fast points get in converged runs [m/s], by the speed of the bar; of several runs the last counts."""
    return {} if truth is None else dict(zip(truth["speed"], truth.numbers["fastest [m/s]"].tolist(), strict=True))


def signs(worst: Worst, possible: float) -> str:
    """Say what failed, parted by commas; no point can be faster than possible [m/s]."""
    if not worst.finite:
        return "NaN"
    failed = {
        "through": worst.through.any(),
        "stretch": worst.stretch > STRETCHED,
        "flung": worst.fastest > possible,
    }
    return ", ".join(sign for sign, seen in failed.items() if seen)


def meet(hair: HairModel, scene: Scene, bar: bool, speed: float, seconds: float) -> Worst:
    """Drive the bar through the tuft at a speed [m/s]; a run that is not finite ends there."""
    state = start(hair, roots_at(hair.groom, speed, 0.0), scene)
    worst = Worst(np.zeros(len(hair.groom.ids), bool))
    with np.errstate(all="ignore"):
        for frame in range(round(seconds / FRAME)):
            try:
                state = _advance(hair, state, scene, bar, speed, frame * FRAME, worst)
            except ArithmeticError:  # what is not finite has no neighbours
                worst.finite = False
            if not worst.finite:
                break
    return worst


def _advance(
    hair: HairModel, state: HairState, scene: Scene, bar: bool, speed: float, began: float, worst: Worst
) -> HairState:
    """Advance by a frame, and check every step."""
    times = began, began + FRAME
    leads = roots_at(hair.groom, speed, times[0]), roots_at(hair.groom, speed, times[1])
    parts = [(bar_at(speed, times[0]), bar_at(speed, times[1]))] if bar else []
    before = hair.layout.axis(state.positions)

    def look(motion: State, *when: float) -> None:
        nonlocal before
        _look(worst, hair, motion, before, [axis_at(speed, began + t)[0] for t in when], bar)
        before = hair.layout.axis(motion.x)

    bodies = bodies_of((), parts, scene.contact, FRAME)
    return advance_frame(hair, state, leads, bodies, FRAME, scene, began, look)


def _look(
    worst: Worst, hair: HairModel, motion: State, before: np.ndarray, axes: Sequence[np.ndarray], bar: bool
) -> None:
    """Note what a step did, in place; axes are points of the bar's axis before and after [m]."""
    points, offsets = hair.layout.axis(motion.x), hair.layout.offsets
    fastest = float(np.linalg.norm(hair.layout.axis(motion.v), axis=1).max())
    lengths = np.delete(np.linalg.norm(np.diff(points, axis=0), axis=1), offsets[1:-1] - 1)
    worst.steps += 1
    worst.finite = bool(np.isfinite(motion.x).all() and np.isfinite(motion.v).all())
    worst.fastest = max(worst.fastest, fastest)
    worst.stretch = max(worst.stretch, float(lengths.max()) * SEGMENTS / LENGTH - 1.0)
    if bar and worst.finite:
        worst.deepest = max(worst.deepest, depth(points - axes[1]))
        worst.through |= passed_through(before - axes[0], points - axes[1], offsets)
