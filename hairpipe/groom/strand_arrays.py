"""Strands in flat arrays: their offsets, some of them, and places along them as shares of their length."""

import numpy as np

RISE = 5
"""Points over which the thickness grows from the root on."""


def offsets_of(counts: np.ndarray) -> np.ndarray:
    """Return the offsets of strands with given numbers of points, (S+1,) int32."""
    return np.concatenate(([0], np.cumsum(counts))).astype(np.int32)


def take_strands(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points and offsets of some of the strands."""
    kept = offsets_of(np.diff(offsets)[ids])
    shift = np.repeat(offsets[ids] - kept[:-1], np.diff(kept))
    return np.ascontiguousarray(points[np.arange(kept[-1]) + shift], dtype=np.float64), kept


def points_of_strands(strands: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the points of some strands, (n,), one strand after another, (m,) int64; pure."""
    counts = np.diff(offsets)[strands].astype(np.int64)
    begins = np.cumsum(counts) - counts
    return np.arange(counts.sum()) + np.repeat(offsets[strands] - begins, counts)


def at_shares(values: np.ndarray, offsets: np.ndarray, strands: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return values of points, (P, 3), at shares 0..1 of the length of strands, linear between points, (n, 3); pure.

    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    strands  strand of each share, (n,)
    """
    segments = (np.diff(offsets) - 1)[strands]
    place = shares * segments
    below = np.minimum(place.astype(int), segments - 1)
    rest = (place - below)[:, None]
    begin = offsets[strands] + below
    return (1.0 - rest) * values[begin] + rest * values[begin + 1]


def shares_of(offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return whose every point is, and at which share of its length, (P,) each."""
    segments = np.diff(offsets) - 1
    strands = np.repeat(np.arange(len(segments)), segments + 1)
    return strands, (np.arange(len(strands)) - offsets[strands]) / segments[strands]


def thicknesses(offsets: np.ndarray, thickness: float) -> np.ndarray:
    """Return what every point keeps from the body [m], (P,): rising from 0 at the root to all of it at the fifth."""
    along = np.arange(offsets[-1]) - np.repeat(offsets[:-1], np.diff(offsets))
    return thickness * np.minimum(along, RISE) / RISE
