"""Observables of chaotic hair: position, volume, motion and stretch, without reference to single strands.

Each is a function of the visible strands, so that it compares any two models of hair; all are pure.
"""

import numpy as np
from scipy.spatial import KDTree

from hairpipe.data import Strands
from hairpipe.data.lengths import segment_lengths, strand_lengths
from hairpipe.groom.strand_arrays import at_shares, shares_of
from hairpipe.measure.tuft import at_levels, nearest
from hairpipe.volume.density import lengths_at_points

SHARES = np.linspace(0.2, 1.0, 5)
"""Shares of the length at which strands are sampled."""
CELL, PIXEL = 0.02, 0.002
"""Side of the cubes in which hair is counted, and of the pixels of silhouettes [m]."""
STRAIN = 0.95
"""Quantile of strain: a lower one is noise, a higher one is of a few segments."""
STILL = 1e-12
"""Power of speed that is treated as zero [m^2/s^2]."""


def resampled(hair: Strands, offsets: np.ndarray) -> Strands:
    """Return hair resampled to the point counts of these offsets, at equal shares of the lengths.

    Raises ValueError if the numbers of strands differ.
    """
    if np.array_equal(hair.offsets, offsets):
        return hair
    if len(hair.offsets) != len(offsets):
        raise ValueError(f"{len(hair.offsets) - 1} strands against {len(offsets) - 1}")
    points, velocities = (
        at_shares(values.astype(float), hair.offsets, *shares_of(offsets)) for values in (hair.points, hair.velocities)
    )
    return Strands(points, velocities.astype(np.float32), offsets, hair.diameter)


def wasserstein(one: np.ndarray, other: np.ndarray) -> float:
    """Return the Wasserstein-1 distance of strands at equal shares of their lengths [m], the mean over shares and axes.

    one, other  positions of strands at each share [m], (shares, S, 3), S not necessarily the same
    """
    from scipy.stats import wasserstein_distance

    pairs = [(a[:, axis], b[:, axis]) for a, b in zip(one, other, strict=True) for axis in range(3)]
    return float(np.mean([wasserstein_distance(*pair) for pair in pairs]))


def places(hair: Strands) -> np.ndarray:
    """Return where every strand is at the shares of its length [m], (shares, S, 3)."""
    return at_levels(hair, SHARES)


def gaps(hair: Strands) -> np.ndarray:
    """Return the mean distance to the nearest other strand at the same share of its length [m], (shares,)."""
    return nearest(places(hair))


def kinetic_energy(hair: Strands, gravity: float) -> float:
    """Return the kinetic energy over m g L, the mean over strands; mass is even along a strand.

    gravity  [m/s^2], above 0
    """
    masses = lengths_at_points(hair.points.astype(float), hair.offsets)
    energies = np.add.reduceat(0.5 * masses * np.sum(hair.velocities.astype(float) ** 2, axis=1), hair.offsets[:-1])
    return float(np.mean(energies / (gravity * strand_lengths(hair.points, hair.offsets) ** 2)))


def log_spectrum(speeds: np.ndarray, fps: float) -> np.ndarray:
    """Return the logarithm of the power of speeds at each frequency but 0, the mean over strands, (frequencies,).

    speeds  of each strand at each frame [m/s], (frames, S)
    """
    from scipy.signal import periodogram

    _, power = periodogram(speeds, fps, scaling="spectrum", axis=0)
    return np.log(power[1:].mean(axis=1) + STILL)


def tip_speeds(hair: Strands) -> np.ndarray:
    """Return the speed of every tip [m/s], (S,)."""
    return np.linalg.norm(hair.velocities[hair.offsets[1:] - 1].astype(float), axis=1)


def contacts(hair: Strands, reach: float) -> float:
    """Return the number of points of other strands within reach [m] of a point, the mean over all but the roots."""
    strand = np.repeat(np.arange(len(hair.offsets) - 1), np.diff(hair.offsets) - 1)
    points = np.delete(hair.points.astype(float), hair.offsets[:-1], axis=0)
    pairs = KDTree(points).query_pairs(reach, output_type="ndarray")
    return 2.0 * np.count_nonzero(strand[pairs[:, 0]] != strand[pairs[:, 1]]) / len(points)


def strain(hair: Strands, rest: np.ndarray) -> float:
    """Return the 95 % quantile of |strain| over all segments, of lengths at rest [m], (P - S,)."""
    return float(np.quantile(np.abs(segment_lengths(hair.points, hair.offsets) / rest - 1.0), STRAIN))


def density(hair: Strands, cell: float = CELL) -> tuple[np.ndarray, np.ndarray]:
    """Return the cubes that contain hair, and the share of hair in each: keys, ascending, and shares, (n,)."""
    points, lengths = _samples(hair, cell)
    keys, where = np.unique(_keys(points / cell), return_inverse=True)
    return keys, np.bincount(where.ravel(), lengths) / lengths.sum()


def density_distance(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> float:
    """Return the share of hair in other cubes, half of the L1 distance of two densities, 0..1."""
    keys = np.union1d(one[0], other[0])
    return 0.5 * float(np.abs(np.subtract(*(_laid(keys, *found) for found in (one, other)))).sum())


def silhouettes(hair: Strands, pixel: float = PIXEL) -> list[np.ndarray]:
    """Return the pixels that hair covers, seen along each axis: keys, ascending, one array a view."""
    points = np.floor(_samples(hair, pixel)[0] / pixel)
    return [np.unique(_keys(np.delete(points, axis, axis=1))) for axis in range(3)]


def silhouette_distance(one: list[np.ndarray], other: list[np.ndarray]) -> float:
    """Return sqrt(1 - IoU), intersection over union of silhouettes, the mean over the views.

    The square root makes it a distance of negative type, whose energy distance is 0 only for equal distributions.
    """
    common = [len(np.intersect1d(*views, assume_unique=True)) for views in zip(one, other, strict=True)]
    whole = [len(a) + len(b) - both for a, b, both in zip(one, other, common, strict=True)]
    return float(np.mean(np.sqrt(1.0 - np.divide(common, whole))))


def _samples(hair: Strands, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places along all segments, no farther apart than half the spacing [m], (n, 3), and the length of each."""
    points = hair.points.astype(float)
    first = np.delete(np.arange(len(hair.points)), hair.offsets[1:] - 1)
    lengths = segment_lengths(hair.points, hair.offsets)
    pieces = max(int(np.ceil(2.0 * lengths.max() / spacing)), 1)
    shares = ((np.arange(pieces) + 0.5) / pieces)[:, None, None]
    found = (1.0 - shares) * points[first] + shares * points[first + 1]
    return found.reshape(-1, 3), np.tile(lengths / pieces, pieces)


def _keys(places: np.ndarray) -> np.ndarray:
    """Return one number for each cell of a grid that holds a place, (n, 2) or (n, 3), within a million cells of 0."""
    keys = np.zeros(len(places), np.int64)
    for column in np.floor(places).astype(np.int64).T:
        keys = (keys << 21) + column + (1 << 20)
    return keys


def _laid(keys: np.ndarray, some: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return shares on a superset of their keys, 0 at the others."""
    laid = np.zeros(len(keys))
    laid[np.searchsorted(keys, some)] = shares
    return laid
