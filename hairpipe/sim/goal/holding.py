"""Goals of a frame: of the whole groom by `[hair.goal]`, and of pinned points."""

from collections.abc import Sequence

import numpy as np

from hairpipe.data import Pins
from hairpipe.errors import BadInput
from hairpipe.sim.boundary import Driver, motion_of_roots
from hairpipe.sim.goal.pull import GoalPull, Path, Springs
from hairpipe.sim.goal.strength import Goal
from hairpipe.sim.hair_model import HairModel


def goals_of(
    hair: HairModel,
    drivers: tuple[Driver, Driver],
    pins: Sequence[tuple[Pins, Pins]],
    goal: Goal | None,
    frame_dt: float,
) -> list[GoalPull]:
    """Return the goals of strands between two frames, frame_dt [s] apart.

    drivers  drivers of the roots of these strands at both frames
    pins     pins at both frames, of all strands, also where these are some of them

    Raises BadInput as `frequencies_of` and `check_pins`.
    """
    if goal is None and not pins:
        return []
    strands = np.repeat(np.arange(len(hair.groom.ids)), np.diff(hair.groom.offsets))
    found = []
    if goal is not None:
        frequency = frequencies_of(goal, hair)
        points = np.flatnonzero(frequency > 0.0)
        springs = _springs(points, hair.masses, frequency[points], goal.damping)
        ends = (motion_of_roots(driver, hair.groom) for driver in drivers)
        path = Path(strands[points], hair.groom.points[points], *(m for end in ends for m in end), frame_dt)
        found.append(GoalPull(springs, path, strands))
    for before, after in pins:
        check_pins(after, hair)
        points = after.points if hair.part_of is None else hair.part_of[1][after.points]
        kept = np.flatnonzero(points >= 0)
        points = points[kept]
        springs = _springs(points, hair.masses, np.full(len(points), after.frequency), after.damping)
        moves = (_shift(values[kept]) for end in (before, after) for values in (end.positions, end.velocities))
        path = Path(np.arange(len(points)), np.zeros((len(points), 3)), *moves, frame_dt)
        found.append(GoalPull(springs, path, strands))
    return found


def check_pins(pins: Pins, hair: HairModel) -> None:
    """Raise BadInput for pins of another groom."""
    whole = hair if hair.part_of is None else hair.part_of[0]
    if pins.among != len(whole.groom.points):
        what = f"pins of a groom of {pins.among} points, for one of {len(whole.groom.points)}"
        raise BadInput(what, where="in.pins", right="pin_hair of the groom that is simulated")


def frequencies_of(goal: Goal, hair: HairModel) -> np.ndarray:
    """Return the frequency of the goal at every point of hair [Hz], (P,); BadInput as `values_of`."""
    values = hair.values_of(goal.frequency, "goal.frequency")
    return np.broadcast_to(values, (2, len(hair.groom.points)))[0]


def _springs(points: np.ndarray, masses: np.ndarray, frequency: np.ndarray, damping: float) -> Springs:
    """Return springs of a frequency [Hz], (k,), and a ratio of damping at points, (k,); masses [kg] are of all."""
    omega = 2.0 * np.pi * frequency
    mass = masses[points]
    return Springs(points.astype(np.int64), mass * omega**2, 2.0 * damping * mass * omega)


def _shift(places: np.ndarray) -> np.ndarray:
    """Return the motions of nothing but the origin to places, or their rates, (k, 3): (k, 3, 4)."""
    motions = np.zeros((len(places), 3, 4))
    motions[:, :, 3] = places
    return motions
