"""Tension on both sides of a post that a strand is wrapped around: the law of Euler and Eytelwein."""

from collections.abc import Mapping

import numpy as np

from hairpipe.data import Groom, Table
from hairpipe.data.hair import HairState
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.tensions import turns
from hairpipe.measure.tension import layout_of, tensions

COLUMNS = ("time [s]", "root [uN]", "tip [uN]", "turned [deg]", "ratio [1]", "ratio error [%]", "change [%]")


def wrapped_table(
    groom: Groom, states: Mapping[int, HairState], fps: float, friction: float, window: tuple[float, float]
) -> Table:
    """Return a row for every frame of a window of time [s], the first frame being time zero, about strand 0.

    A strand without bending stiffness that slides towards the tip over a post has T_root / T_tip = exp(mu a), with the
    angle a between the straight parts on both sides.

    root, tip  tension of the first and of the last segment that is not held
    turned     a
    ratio      of both tensions, and its error against the exponential
    change     of the ratio since the first frame of the window, over that

    BadInput where no frame is in the window.
    """
    frames = list(states)
    seen = [frame for frame in frames if window[0] <= (frame - frames[0]) / fps <= window[1]]
    if not seen:
        raise BadInput(f"no frame from {window[0]:g} to {window[1]:g} s", right="times of the run")
    layout = layout_of(groom, states[seen[0]])
    rows, first = [], np.nan
    for frame in seen:
        points, pulls = next((points, pulls) for strand, points, pulls in tensions(layout, states[frame]) if strand == 0)
        angle = abs(float(turns(points)[-1]))
        ratio = float(pulls[1] / pulls[-2])
        first = first if rows else ratio
        error = 100.0 * (ratio / np.exp(friction * np.radians(angle)) - 1.0)
        time = (frame - frames[0]) / fps
        rows.append((time, 1e6 * float(pulls[1]), 1e6 * float(pulls[-2]), angle, ratio, error, 100.0 * (ratio / first - 1.0)))
    return table_of_rows(COLUMNS, rows)
