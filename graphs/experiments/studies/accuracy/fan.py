"""One strand in several orientations about the vertical: a model that prefers none does the same in all of them."""

from collections.abc import Mapping

import numpy as np

from hairpipe.groom.strands import unbound
from hairpipe.values import Groom, Strands, Table
from hairpipe.values.table import table_of_rows

COLUMNS = ("time [s]", "difference [% of length]")


def headings(count: int) -> np.ndarray:
    """Rotations about +Y by equal parts of a turn, (count, 3, 3)."""
    angles = 2 * np.pi * np.arange(count) / count
    c = np.cos(angles)
    s = np.sin(angles)
    zero = np.zeros(count)
    return np.stack([c, zero, s, zero, zero + 1, zero, -s, zero, c], axis=1).reshape(-1, 3, 3)


def fanned(groom: Groom, count: int, radius: float) -> Groom:
    """Return the first strand of a groom in headings, with its root's frame, all roots on a circle [m]; pure."""
    points = groom.points[: groom.offsets[1]].copy()
    frame = groom.root_frames[0].copy()
    points[:, 0] += radius
    frame[0, 3] += radius
    turns = headings(count)
    return unbound(points @ turns.transpose(0, 2, 1), turns @ frame)


def fan_table(hair: Mapping[int, Strands], fps: float) -> Table:
    """Tabulate how far the strands of a fan are from the first, turned to it: the farthest point, frame by frame."""
    rows = []
    frames = list(hair)
    for frame in frames:
        strands = hair[frame]
        points = strands.points.reshape(len(strands.offsets) - 1, -1, 3).astype(float)
        turned = points @ headings(len(points))  # each by the inverse of its own
        length = np.linalg.norm(np.diff(points[0], axis=0), axis=1).sum()
        away = np.linalg.norm(turned - turned[0], axis=2).max()
        rows.append(((frame - frames[0]) / fps, 100 * away / length))
    return table_of_rows(COLUMNS, rows)
