"""How deep hair is inside a body."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numba import njit

from hairpipe.data import LevelSet, Strands, Table
from hairpipe.data.table import table_of_rows
from hairpipe.levelset.field import Field, field_of
from hairpipe.levelset.sample import distance

COLUMNS = ("time [s]", "deepest [mm]", "99 % within [mm]", "points inside", "points")


def measure_depths(hair: Mapping[int, Strands], surfaces: Sequence[Mapping[int, LevelSet]], fps: float) -> Table:
    """Return a row for every frame, over all points but the roots, which the body holds; time zero is the first frame.

    surfaces        of the bodies: a point is as deep as in the one that it is deepest in
    deepest         point inside a body, 0 where all are outside
    99 % within     depth that 99 of 100 points do not exceed
    """
    frames = list(hair)
    rows: list[tuple[Any, ...]] = []
    for frame in frames:
        depth = depths(hair[frame], [field_of(surface[frame]) for surface in surfaces])
        deep = (1e3 * depth.max(initial=0.0), 1e3 * np.percentile(depth, 99.0) if len(depth) else 0.0)
        rows.append(((frame - frames[0]) / fps, *deep, np.count_nonzero(depth), len(depth)))
    return table_of_rows(COLUMNS, rows)


def depths(hair: Strands, fields: Sequence[Field]) -> np.ndarray:
    """Return how deep all points but the roots are inside the union of bodies [m], (P - S,); 0 where outside."""
    free = np.delete(hair.points.astype(float), hair.offsets[:-1], axis=0)
    deepest = np.zeros(len(free))
    for field in fields:
        _deepen(field, free, deepest)
    return deepest


@njit(cache=True)
def _deepen(field: Field, points: np.ndarray, deepest: np.ndarray) -> None:
    """Raise depths to those in one more body, in place."""
    for p in range(len(points)):
        deepest[p] = max(deepest[p], -distance(field, points[p, 0], points[p, 1], points[p, 2]))
