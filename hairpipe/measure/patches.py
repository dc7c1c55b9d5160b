"""Deviation of a sample of hair from a reference, patch by patch: their spread is the uncertainty of the sample."""

from collections.abc import Mapping
from itertools import pairwise

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.measure.deviation import deviation

COLUMNS = ("frame", "patch", "strands", "tip [m]", "whole [m]", "tip [%]", "whole [%]", "lost")


def measure_patches(hair: Mapping[int, Strands], reference: Mapping[int, Strands], patches: int) -> Table:
    """Return a row for every frame and patch: root mean square of the distances as in `deviation`.

    patches  number of patches of consecutive strands, as equal as possible
    Raises BadInput if the strands differ, or are fewer than the patches.
    """
    rows = []
    for frame in hair:
        now, true = hair[frame], reference[frame]
        count = len(now.offsets) - 1
        if count != len(true.offsets) - 1 or count < patches:
            where = f"{count} strands against {len(true.offsets) - 1}"
            raise BadInput(where, right=f"the same strands, at least {patches}")
        bounds = [patch * count // patches for patch in range(patches + 1)]
        for patch, (begin, end) in enumerate(pairwise(bounds)):
            found = deviation(part(now, begin, end), part(true, begin, end))
            distances = (found.tip, found.whole, found.tip_percent, found.whole_percent)
            rows.append((frame, patch, end - begin, *distances, len(found.lost)))
    return table_of_rows(COLUMNS, rows)


def part(hair: Strands, begin: int, end: int) -> Strands:
    """Return the strands from one on and before another; pure."""
    points = slice(hair.offsets[begin], hair.offsets[end])
    offsets = hair.offsets[begin : end + 1] - hair.offsets[begin]
    return Strands(hair.points[points], hair.velocities[points], offsets, hair.diameter)
