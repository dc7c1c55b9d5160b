"""Spread and clumping of a tuft."""

from collections.abc import Mapping

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.measure.contact import at_levels, nearest
from hairpipe.values import Strands, Table
from hairpipe.values.table import table_of_rows

COLUMNS = ("time [s]", "spread of tips [mm]", "nearest strand [mm]", "over random [1]")


def measure_spread(hair: Mapping[int, Strands], fps: float) -> Table:
    """Return a row for every frame; time zero is the first.

    spread of tips   root mean square distance from their mean
    nearest strand   mean distance to the nearest other, at the same share of its length, in the outer half
    over random      the same over its value for random strands on a disc of this spread: 1 is random, 2 an
                     even lattice, less than 1 clumps (Clark and Evans, Distance to Nearest Neighbor, 1954)
    Raise BadInput where there are fewer than two strands.
    """
    frames = list(hair)
    if len(hair[frames[0]].offsets) < 3:
        raise BadInput("a tuft needs more than one strand", where="hair", right="two strands or more")
    rows = []
    for frame in frames:
        levels = at_levels(hair[frame])
        gaps = nearest(levels)
        spreads = spread(levels)
        chance = 0.5 * spreads * np.sqrt(2.0 * np.pi / levels.shape[1])
        share = np.mean(np.divide(gaps, chance, out=np.ones_like(gaps), where=chance > 0.0))
        rows.append(((frame - frames[0]) / fps, 1e3 * spreads[-1], 1e3 * gaps.mean(), share))
    return table_of_rows(COLUMNS, rows)


def spread(levels: np.ndarray) -> np.ndarray:
    """Return the root mean square distance of strands from their mean at every level [m], (levels,)."""
    away = levels - levels.mean(axis=1, keepdims=True)
    return np.sqrt(np.sum(away**2, axis=2).mean(axis=1))
