"""Contact of hair with bodies and with itself: depth, speed, stretch, crossings of two locks, and packing."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider, probe_union
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.measure.deviation import deviation
from hairpipe.values import BodyParts, LevelSet, Strands, Table
from hairpipe.values.groom import reach_of, segment_lengths
from hairpipe.values.strand_arrays import at_shares
from hairpipe.values.table import table_of_rows
from hairpipe.volume.transfer import sample_strands

ROOM = 1e-3  # distance from the body of a free position: the default thickness of hair [m]
_STEPS = 12
_ENOUGH = 0.5  # of the clearance; distances are not exact
_FARTHEST = 2.0  # length of the traced path, over the sum of depth and clearance


def is_pinched(points: np.ndarray, depth: np.ndarray, bodies: Sequence[Collider]) -> np.ndarray:
    """Return the points inside bodies [m], (P, 3), without free space, as where two bodies overlap, (P,).

    A path out is traced along the normals, out of every body that it enters, up to twice the sum of depth and
    clearance: a point is pinched if there is no free position on it. It is not pinched if the path ends at an
    undefined normal.
    """
    places = points.copy()
    pinched = np.ones(len(points), bool)
    reach = _FARTHEST * (depth + ROOM)
    for _ in range(_STEPS):
        probe = probe_union(bodies, places, 2.0 * ROOM)
        near = np.linalg.norm(places - points, axis=1) <= reach
        outside = (probe.distance > _ENOUGH * ROOM) & near
        lost = (probe.distance < 0.0) & ~probe.normal.any(axis=1)
        pinched &= ~(outside | lost)
        places += np.maximum(ROOM - probe.distance, 0.0)[:, None] * probe.normal
    return pinched


COLUMNS = (
    *("time [s]", "deepest [mm]", "99 % quantile [mm]", "points inside", "points"),  # deepest: 0 without points inside
    *("still inside [mm]", "points still inside"),  # strands inside since the first frame; excluded elsewhere
    *("pinched [mm]", "points pinched"),  # points between bodies without free space; excluded elsewhere
    *("fastest point [m/s]", "segment stretch [%]"),  # the largest, over the length in the first frame
)


def measure_contacts(
    hair: Mapping[int, Strands],
    surfaces: Sequence[Mapping[int, LevelSet]],
    parts: Sequence[Mapping[int, BodyParts]],
    fps: float,
) -> Table:
    """Return a row for every frame, over all points but the roots; time zero is the first frame.

    surfaces, parts  level sets of the bodies; the depth of a point is the largest in any body
    """
    frames = list(hair)
    rest = segment_lengths(hair[frames[0]].points, hair[frames[0]].offsets)
    rest[rest == 0.0] = np.inf
    rows: list[tuple[Any, ...]] = []
    late_strands: np.ndarray | None = None
    counts = np.diff(hair[frames[0]].offsets) - 1
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    for frame in frames:
        bodies = still((surface[frame] for surface in surfaces), (part[frame] for part in parts))
        depth = depths(hair[frame], bodies)
        inside = np.add.reduceat(depth > 0.0, starts) > 0
        late_strands = inside if late_strands is None else late_strands & inside
        begun = np.repeat(late_strands, counts) & (depth > 0.0)
        pinched = np.zeros_like(begun)
        others = np.flatnonzero((depth > 0.0) & ~begun)
        pinched[others] = is_pinched(free_points(hair[frame])[others], depth[others], bodies)
        missed = np.where(begun | pinched, 0.0, depth)
        quantile = 1e3 * np.percentile(missed, 99.0) if len(missed) else 0.0
        deep = 1e3 * missed.max(initial=0.0), quantile, np.count_nonzero(missed), len(depth)
        left = 1e3 * depth[begun].max(initial=0.0), np.count_nonzero(begun)
        left = *left, 1e3 * depth[pinched].max(initial=0.0), np.count_nonzero(pinched)
        moving = without_roots(hair[frame].velocities, hair[frame])
        speed = np.linalg.norm(moving, axis=1).max(initial=0.0)
        stretch = 100.0 * (segment_lengths(hair[frame].points, hair[frame].offsets) / rest - 1.0).max(initial=-1.0)
        rows.append(((frame - frames[0]) / fps, *deep, *left, speed, stretch))
    return table_of_rows(COLUMNS, rows)


def still(surfaces: Iterable[LevelSet], parts: Iterable[BodyParts]) -> list[Collider]:
    """Make the colliders of bodies, at rest in the pose of a frame."""
    fields = (build_collider_field(surface, surface, 1.0, Interpolation.linear) for surface in surfaces)
    return [*fields, *(build_collider_parts(part, part, 1.0) for part in parts)]


def depths(hair: Strands, bodies: Sequence[Collider]) -> np.ndarray:
    """Return the depth of all points but the roots inside the union of bodies [m], (P - S,); 0 outside."""
    return 0.0 - probe_union(bodies, free_points(hair), 0.0).distance


def free_points(hair: Strands) -> np.ndarray:
    """Return the points but the roots, which are prescribed [m], (P - S, 3)."""
    return without_roots(hair.points, hair)


def without_roots(values: np.ndarray, hair: Strands) -> np.ndarray:
    """Return values of the points but the roots, (P - S, 3) float64."""
    return np.delete(values.astype(float), hair.offsets[:-1], axis=0)


def touching(hair: Strands, reach: float) -> np.ndarray:
    """Return the pairs of points of different strands, but the roots, within reach [m], (n, 2)."""
    strand = np.repeat(np.arange(len(hair.offsets) - 1), np.diff(hair.offsets) - 1)
    pairs = KDTree(free_points(hair)).query_pairs(reach, output_type="ndarray")
    return pairs[strand[pairs[:, 0]] != strand[pairs[:, 1]]]


LEVELS = np.linspace(0.5, 1.0, 9)  # shares of the length at which strands are sampled, in the outer half

CROSSING_COLUMNS = ("time [s]", "crossed pairs [%]", "crossed hairs [%]")
"""A pair, a hair of each lock, is crossed in the opposite order of its roots along the line from the mean root of the
first lock to that of the second, at a share of length in the outer half; a hair is crossed in most of its pairs."""


def measure_crossing(hair: Mapping[int, Strands], count: int, fps: float) -> Table:
    """Return a row for every frame, of two locks; time zero is the first. BadInput where one has no strands.

    count  of strands in the first lock, which come first
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
    return table_of_rows(CROSSING_COLUMNS, rows)


def at_levels(hair: Strands, levels: np.ndarray = LEVELS) -> np.ndarray:
    """Return the position of every strand at shares of its length [m], (levels, S, 3)."""
    strands, shares = (grid.ravel() for grid in np.meshgrid(np.arange(len(hair.offsets) - 1), levels))
    places = at_shares(hair.points.astype(float), hair.offsets, strands, shares)
    return places.reshape(len(levels), -1, 3)


def nearest(levels: np.ndarray) -> np.ndarray:
    """Return the mean distance to the nearest other strand at every level [m], (levels,)."""
    return np.array([KDTree(points).query(points, 2)[0][:, 1].mean() for points in levels])


PACKING_COLUMNS = (
    "neighbours [m/s]",  # relative speed of a point, roots excluded, and the nearest point of another strand
    "nearest strand [mm]",  # mean distance at the same share of the length
    "volume [l]",  # of cells with hair: length of hair over the density around it, summed up
    "density 99 % [km/l]",  # length of hair per volume: the 99 % quantile, by length of hair
    "overlap [1]",  # of the histograms of density, by length of hair, of hair and reference: 1 if equal
    "strand error [% of length]",  # against the reference, see `deviation`
)
DENSEST = 0.99  # quantile of the density around hair
PER_OCTAVE = 2  # bins of the histogram of density to a doubling of it


def packing_table(
    hair: Mapping[int, Strands], reference: Mapping[int, Strands], cell: float, near: float, skip: int
) -> Table:
    """Return one row, means over the frames but the first ones skipped; of speeds and errors, root mean squares.

    cell, near  side of the cubes in which hair is counted, distance up to which points are neighbours [m]

    Raises BadInput where strands do not correspond, or no frames are left.
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
    return table_of_rows(PACKING_COLUMNS, [tuple(row)])


def relative_speed(hair: Strands, near: float) -> float:
    """Return the root mean square speed of points against their nearest neighbours [m/s]; 0 without any."""
    points = free_points(hair)
    speeds = without_roots(hair.velocities, hair)
    pairs = touching(hair, near)
    one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    order = np.lexsort((other, np.linalg.norm(points[one] - points[other], axis=1), one))
    _, first = np.unique(one[order], return_index=True)
    one, other = one[order][first], other[order][first]
    squares = np.sum((speeds[one] - speeds[other]) ** 2, axis=1)
    return float(np.sqrt(squares.mean())) if len(squares) else 0.0


def densities(hair: Strands, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the density of hair around samples along strands [m/m^3], as on the grid of a volume, and lengths [m]."""
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
    """Return the common area of the histograms of two densities, by length, as from `densities`."""
    bins = [np.floor(PER_OCTAVE * np.log2(density)).astype(int) for density, _ in (one, other)]
    least = min(b.min() for b in bins)
    most = max(b.max() for b in bins) - least + 1
    shares = [
        np.bincount(b - least, length, most) / length.sum() for b, (_, length) in zip(bins, (one, other), strict=True)
    ]
    return float(np.minimum(*shares).sum())
