"""Distance of hair from a reference of the same hair, also where the two differ in their segments.

Of a sample of hair it is measured patch by patch: their spread is the uncertainty of the sample.
"""
# pyright: reportCallIssue=false

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Strands, Table
from hairpipe.values.groom import strand_lengths
from hairpipe.values.strand_arrays import at_shares
from hairpipe.values.table import table_of_rows


class Deviation(NamedTuple):
    """Distances of hair from a reference at one frame; non-finite strands are excluded."""

    tip: float  # root mean square over the strands [m]
    whole: float  # over strands and points except the roots, strands of any length weighted equally [m]
    tip_percent: float  # the same as `tip`, over the length of each strand in the reference [%]
    whole_percent: float
    largest: float  # largest distance of a point [m]
    lost: np.ndarray  # strands of the hair with a point that is not finite, (n,) int64


def deviation(hair: Strands, reference: Strands, whose: np.ndarray | None = None) -> Deviation:
    """Compare strands with a reference, in order or each with one of it, `whose`, (S,), at points of the latter. Pure.

    Segments of a strand are of equal length, so a share of its length is a share of its segments, stretched or not;
    between two points it is linear. All values are NaN without finite strands. ValueError if strands do not match.
    """
    count = len(hair.offsets) - 1
    whose = np.arange(len(reference.offsets) - 1) if whose is None else np.asarray(whose)
    if len(whose) != count or (count and not 0 <= whose.min() <= whose.max() < len(reference.offsets) - 1):
        raise ValueError(f"{count} strands against {len(whose)} of {len(reference.offsets) - 1}")
    segments = np.diff(reference.offsets)[whose] - 1
    first = np.concatenate([[0], np.cumsum(segments)[:-1]]).astype(int)
    strand = np.repeat(np.arange(count), segments)
    index = 1 + np.arange(len(strand)) - first[strand]
    true = reference.points[reference.offsets[whose][strand] + index].astype(float)
    points = hair.points.astype(float)
    with np.errstate(invalid="ignore", over="ignore"):
        away = np.linalg.norm(at_shares(points, hair.offsets, strand, index / segments[strand]) - true, axis=1)
    lengths = strand_lengths(reference.points, reference.offsets)[whose]
    lost = np.flatnonzero(~np.logical_and.reduceat(np.isfinite(hair.points).all(axis=1), hair.offsets[:-1]))
    kept = np.setdiff1d(np.arange(count), lost)
    if not len(kept):
        return Deviation(*[np.nan] * 5, lost)
    tips = away[first + segments - 1]
    wholes = np.sqrt(np.add.reduceat(away**2, first) / segments)
    shares = 100.0 * tips / lengths, 100.0 * wholes / lengths
    largest = float(np.maximum.reduceat(away, first)[kept].max())
    squares = (np.mean(values[kept] ** 2) for values in (tips, wholes, *shares))
    return Deviation(*(float(np.sqrt(square)) for square in squares), largest, lost)


PATCH_COLUMNS = ("frame", "patch", "strands", "tip [m]", "whole [m]", "tip [%]", "whole [%]", "lost")


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
        for patch, (ours, theirs) in enumerate(zip(patches_of(now, patches), patches_of(true, patches), strict=True)):
            found = deviation(ours, theirs)
            distances = (found.tip, found.whole, found.tip_percent, found.whole_percent)
            rows.append((frame, patch, len(ours.offsets) - 1, *distances, len(found.lost)))
    return table_of_rows(PATCH_COLUMNS, rows)


def patches_of(hair: Strands, patches: int) -> Iterator[Strands]:
    """Split hair into patches of consecutive strands, as equal as possible; pure."""
    bounds = [patch * (len(hair.offsets) - 1) // patches for patch in range(patches + 1)]
    for begin, end in pairwise(bounds):
        points = slice(hair.offsets[begin], hair.offsets[end])
        offsets = hair.offsets[begin : end + 1] - hair.offsets[begin]
        yield Strands(hair.points[points], hair.velocities[points], offsets, hair.diameter)
