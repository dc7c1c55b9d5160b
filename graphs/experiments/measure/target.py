"""Hair against a density that it is led to, frame by frame."""

from collections.abc import Mapping

import numpy as np

from hairpipe.values import Density, Strands, Table
from hairpipe.values.table import table_of_rows
from hairpipe.volume.density import lengths_at_points
from hairpipe.volume.strand_samples import reach_of
from hairpipe.volume.targeting import Hair, energy, target_grids

COLUMNS = ("frame", "of the first [1]", "of no hair [1]")
_RATE = 1.0  # cancels


def target_table(hair: Mapping[int, Strands], target: Mapping[int, Density], cell: float, levels: int) -> Table:
    """Return a row for every frame: the energy of `targeting`, over that of the first frame, and over that of no hair.

    cell    of the finest grid [m]; levels  grids
    Raises BadInput as `target_grids` does.
    """
    rows = []
    first = None
    for frame in hair:
        now = hair[frame]
        points = now.points.astype(float)
        hair_now = Hair(points, now.offsets, reach_of(points, now.offsets), lengths_at_points(points, now.offsets))
        grids = target_grids(target[frame], cell, levels, hair_now.lengths.sum())
        found = energy(hair_now, grids, _RATE)
        nothing = sum(0.5 * (_RATE * g.cell) ** 2 * g.cell**3 * g.length.sum() for g in grids)
        first = found if first is None else first
        rows.append((frame, found / first if first > 0.0 else np.nan, found / nothing))
    return table_of_rows(COLUMNS, rows)
