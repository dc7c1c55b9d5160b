"""Swing of hair about a head that turns: amplitude and lag."""

from collections.abc import Mapping

import numpy as np

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput

COLUMNS = ("lag [frames]", "correlation [1]", "swing [degrees]", "swing of the roots [degrees]")
LOWER = 0.75
"""Share of the points of a strand after which the lower quarter begins."""
FINE = 10
"""Number of tried lags per frame."""
LONGEST = 0.25
"""Longest lag, over the duration of the shot."""


def swing_table(hair: Mapping[int, Strands]) -> Table:
    """Return one row.

    swing  peak-to-peak rotation of the lower quarters of all strands since the first frame, about the vertical
           through the middle of the roots, in least squares
    lag    delay of the largest correlation of this angle with that of the roots

    BadInput where roots do not turn.
    """
    low, roots = [], []
    for frame in hair:
        ends = hair[frame].offsets
        points = hair[frame].points.astype(float)[:, [2, 0]]
        starts = (ends[:-1] + np.ceil(LOWER * np.diff(ends))).astype(int)
        middle = points[ends[:-1]].mean(axis=0)
        cuts = np.stack([starts, ends[1:]], axis=1).ravel()
        sums = np.add.reduceat(np.append(points, [[0.0, 0.0]], axis=0), cuts)[::2]
        low.append(sums / (ends[1:] - starts)[:, None] - middle)
        roots.append(points[ends[:-1]] - middle)
    swung, driven = _turns(low), _turns(roots)
    if not np.ptp(driven) > 0.0:
        raise BadInput("the roots of the hair do not turn", where="in.hair", right="hair on a head that shakes")
    lags = np.arange(int(LONGEST * FINE * len(driven)) + 1) / FINE
    fits = [_correlation(driven, swung, lag) for lag in lags]
    best = int(np.argmax(fits))
    return table_of_rows(COLUMNS, [(lags[best], fits[best], np.ptp(swung), np.ptp(driven))])


def _turns(places: list[np.ndarray]) -> np.ndarray:
    """Return the rotation of places, (n, 2) each, since the first frame [degrees], (frames,)."""
    first = places[0]
    sines = [np.sum(first[:, 0] * now[:, 1] - first[:, 1] * now[:, 0]) for now in places]
    cosines = [np.sum(first * now) for now in places]
    return np.degrees(np.unwrap(np.arctan2(sines, cosines)))


def _correlation(first: np.ndarray, second: np.ndarray, lag: float) -> float:
    """Return the correlation of a series with another one, delayed by so many samples."""
    at = np.arange(len(first) - int(np.ceil(lag)))
    return float(np.corrcoef(first[at], np.interp(at + lag, np.arange(len(second)), second))[0, 1])
