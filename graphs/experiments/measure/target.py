"""Hair against a density that it is led to, frame by frame."""

from collections.abc import Mapping

import numpy as np

from hairpipe.values import Density, Strands, Table
from hairpipe.values.groom import lengths_at_points, reach_of
from hairpipe.values.table import table_of_rows
from hairpipe.volume.targeting import Hair, TargetGrid, densities_in, target_grids
from hairpipe.volume.transfer import sample_strands

COLUMNS = ("frame", "of the first [1]", "of no hair [1]")
_RATE = 1.0  # cancels


def target_table(hair: Mapping[int, Strands], target: Mapping[int, Density], cell: float, levels: int) -> Table:
    """Return a row for every frame: the energy, over that of the first frame, and over that of no hair.

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


def energy(hair: Hair, targets: list[TargetGrid], rate: float) -> float:
    """Return E of `targeting` of hair on all grids, over its mass per length [m^3/s^2]; pure."""
    total = 0.0
    for target in targets:
        samples = sample_strands(hair.points, hair.offsets, hair.reach, target.cell)
        if samples is not None:
            density, wanted, seen = densities_in(samples, hair.lengths, target)
            beyond = np.sum(target.length**2) - np.sum(wanted**2)  # the target outside of the hair
            differences = np.sum((density - wanted) ** 2) + beyond
            total += 0.5 * (rate * target.cell) ** 2 / seen * target.cell**3 * differences
    return total
