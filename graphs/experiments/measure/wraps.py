"""Tension on both sides of a post that a strand is wrapped around: the law of Euler and Eytelwein."""

from collections.abc import Mapping

import numpy as np

from hairpipe.graphs.experiments.measure.tensions import first_strand, frames_between, turns
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

COLUMNS = ("time [s]", "root [uN]", "tip [uN]", "turned [deg]", "ratio [1]", "ratio error [%]", "tip moved [mm]")


def wrapped_table(
    groom: Groom, states: Mapping[int, HairState], fps: float, friction: float, window: tuple[float, float]
) -> Table:
    """Return a row for every frame of a window of time [s] about strand 0.

    A strand without bending stiffness that slides towards the tip over a post has T_root / T_tip = exp(mu a), with the
    angle a between the straight parts on both sides.

    root, tip  tension of the first and of the last segment that is not held
    turned     a
    ratio      of both tensions, NaN where there is none, and its error against the exponential
    tip moved  displacement of the tip since the first of these frames

    BadInput where no frame is in the window.
    """
    rows = []
    start = np.zeros(3)
    for frame, time in frames_between(list(states), fps, window):
        points, pulls = first_strand(groom, states[frame])
        angle = abs(float(turns(points)[-1]))
        root, tip = float(pulls[1]), float(pulls[-2])
        ratio = root / tip if tip else np.nan
        error = 100.0 * (ratio / np.exp(friction * np.radians(angle)) - 1.0)
        start = start if rows else points[-1]
        moved = 1e3 * float(np.linalg.norm(points[-1] - start))
        rows.append((time, 1e6 * root, 1e6 * tip, angle, ratio, error, moved))
    return table_of_rows(COLUMNS, rows)
