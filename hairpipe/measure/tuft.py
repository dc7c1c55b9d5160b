"""Distances within a tuft, and crossings of two locks."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.groom.strand_arrays import at_shares

LEVELS = np.linspace(0.5, 1.0, 9)
"""Shares of the length at which strands are sampled, in the outer half."""

COLUMNS = ("time [s]", "crossed pairs [%]", "crossed hairs [%]")


def measure_crossing(hair: Mapping[int, Strands], count: int, fps: float) -> Table:
    """Return a row for every frame, of two locks; time zero is the first.

    count  of strands in the first lock, which come first

    crossed pairs  of one hair of each lock, in the opposite order of their roots along the line from the mean root of
                   the first lock to that of the second, at the same share of length, in the outer half
    crossed hairs  hairs crossed in more than half of their pairs, over all these shares
    Raise BadInput where one lock has no strands.
    """
    frames = list(hair)
    total = len(hair[frames[0]].offsets) - 1
    if not 0 < count < total:
        raise BadInput(f"{count} of {total} strands leave none for a second lock", where="in.lock", right="fewer")
    rows = []
    for frame in frames:
        roots = hair[frame].points[hair[frame].offsets[:-1]].astype(float)
        way = roots[count:].mean(axis=0) - roots[:count].mean(axis=0)
        places = at_levels(hair[frame]) @ way
        crossed = places[:, :count, None] > places[:, None, count:]
        hairs = np.concatenate([crossed.mean(axis=axes) > 0.5 for axes in ((0, 2), (0, 1))])
        rows.append(((frame - frames[0]) / fps, 100.0 * crossed.mean(), 100.0 * hairs.mean()))
    return table_of_rows(COLUMNS, rows)


def at_levels(hair: Strands, levels: np.ndarray = LEVELS) -> np.ndarray:
    """Return the position of every strand at shares of its length [m], (levels, S, 3)."""
    strands, shares = (grid.ravel() for grid in np.meshgrid(np.arange(len(hair.offsets) - 1), levels))
    places = at_shares(hair.points.astype(float), hair.offsets, strands, shares)
    return places.reshape(len(levels), -1, 3)


def nearest(levels: np.ndarray) -> np.ndarray:
    """Return the mean distance to the nearest other strand at every level [m], (levels,)."""
    return np.array([KDTree(points).query(points, 2)[0][:, 1].mean() for points in levels])
