"""Packing of hair: density, volume, and relative speed of neighbours."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.measure.deviation import deviation
from hairpipe.measure.tuft import at_levels, nearest
from hairpipe.volume.strand_samples import reach_of, sample_strands

COLUMNS = (
    "neighbours [m/s]",
    "nearest strand [mm]",
    "volume [l]",
    "density 99 % [km/l]",
    "overlap [1]",
    "strand error [% of length]",
)
DENSEST = 0.99
"""Quantile of the density around hair."""
PER_OCTAVE = 2
"""Bins of the histogram of density to a doubling of it."""


def packing_table(
    hair: Mapping[int, Strands], reference: Mapping[int, Strands], cell: float, near: float, skip: int
) -> Table:
    """Return one row, means over the frames; of speeds and errors, root mean squares.

    cell  side of the cubes in which hair is counted [m]
    near  distance up to which points of two strands are neighbours [m]
    skip  frames at the beginning that are excluded

    neighbours      relative speed of a point, roots excluded, and the nearest point of another strand
    nearest strand  mean distance at the same share of the length, see `tuft`
    volume          of cells with hair: length of hair over the density around it, summed up
    density         length of hair per volume: the 99 % quantile, by length of hair
    overlap         of the histograms of density, by length of hair, of hair and reference: 1 if equal
    strand error    against the reference, see `deviation`
    Raise BadInput where strands do not correspond, or no frames are left.
    """
    frames = list(hair)[skip:]
    if not frames:
        raise BadInput("no frames are left to measure", right=f"more than {skip} frames")
    rows = []
    for frame in frames:
        now, true = hair[frame], reference[frame]
        try:
            error = deviation(now, true).whole_percent
        except ValueError as wrong:
            raise BadInput(f"hair and reference do not correspond: {wrong}", right="the same groom") from None
        density, length = densities(now, cell)
        order = np.argsort(density)
        share = np.cumsum(length[order]) / length.sum()
        densest = density[order][np.searchsorted(share, DENSEST)]
        both = overlap((density, length), densities(true, cell))
        gaps = nearest(at_levels(now)).mean()
        squares = relative_speed(now, near) ** 2, error**2
        rows.append((squares[0], 1e3 * gaps, 1e3 * np.sum(length / density), 1e-6 * densest, both, squares[1]))
    row = np.mean(rows, axis=0)
    row[[0, -1]] = np.sqrt(row[[0, -1]])
    return table_of_rows(COLUMNS, [tuple(row)])


def relative_speed(hair: Strands, near: float) -> float:
    """Return the root mean square speed of points against their nearest neighbours [m/s]; 0 without any; pure."""
    points = np.delete(hair.points.astype(float), hair.offsets[:-1], axis=0)
    speeds = np.delete(hair.velocities.astype(float), hair.offsets[:-1], axis=0)
    strand = np.repeat(np.arange(len(hair.offsets) - 1), np.diff(hair.offsets) - 1)
    pairs = KDTree(points).query_pairs(near, output_type="ndarray")
    pairs = pairs[strand[pairs[:, 0]] != strand[pairs[:, 1]]]
    one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    order = np.lexsort((other, np.linalg.norm(points[one] - points[other], axis=1), one))
    _, first = np.unique(one[order], return_index=True)
    one, other = one[order][first], other[order][first]
    squares = np.sum((speeds[one] - speeds[other]) ** 2, axis=1)
    return float(np.sqrt(squares.mean())) if len(squares) else 0.0


def densities(hair: Strands, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the density of hair around every sample along the strands [m/m^3], and its length [m], (n,); pure.

    A segment is sampled as on the grid of `[hair.volume]`. BadInput where no strand is finite.
    """
    points = hair.points.astype(float)
    found = sample_strands(points, hair.offsets, reach_of(points, hair.offsets), cell)
    if found is None:
        raise BadInput("no strand is sound", where="hair", right="finite points")
    k = found.segments
    pieces = found.pieces[found.segments]
    ways = points[k + 1] - points[k]
    length = np.linalg.norm(ways, axis=1) / pieces
    cells = np.floor((points[k] + ((found.places + 0.5) / pieces)[:, None] * ways) / cell)
    _, where = np.unique(cells, axis=0, return_inverse=True)
    where = where.ravel()
    return np.bincount(where, length)[where] / cell**3, length


def overlap(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> float:
    """Return the common area of the histograms of two densities, by length, as from `densities`; pure."""
    bins = [np.floor(PER_OCTAVE * np.log2(density)).astype(int) for density, _ in (one, other)]
    least = min(b.min() for b in bins)
    most = max(b.max() for b in bins) - least + 1
    shares = [
        np.bincount(b - least, length, most) / length.sum() for b, (_, length) in zip(bins, (one, other), strict=True)
    ]
    return float(np.minimum(*shares).sum())
