"""Pairs of segments, and sorted lists in which a pair is looked up."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.spatial.segment_distance import closest_of


class Pairs(NamedTuple):
    """Pairs of segments near each other. Segment i joins points i and i + 1.

    segments   first < second, rows in lexicographic order, (n, 2) int32
    fractions  of the segments where they are closest, (n, 2) float64
    distances  between these places [m], (n,) float64
    """

    segments: np.ndarray
    fractions: np.ndarray
    distances: np.ndarray


def empty_pairs() -> Pairs:
    """Return no pairs."""
    return Pairs(np.empty((0, 2), np.int32), np.empty((0, 2)), np.empty(0))


def chosen(pairs: Pairs, keep: np.ndarray) -> Pairs:
    """Return the pairs that are marked, (n,) bool."""
    if keep.all():
        return pairs
    where = np.flatnonzero(keep)
    out = Pairs(*(np.empty((len(where), *field.shape[1:]), field.dtype) for field in pairs))
    _copy(pairs, where, *out)
    return out


@njit(cache=True, parallel=True)
def _copy(pairs, where, segments, fractions, distances):
    for k in prange(len(where)):
        for j in range(2):
            segments[k, j], fractions[k, j] = pairs.segments[where[k], j], pairs.fractions[where[k], j]
        distances[k] = pairs.distances[where[k]]


def picked(pairs: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Return the pairs of segments, (n, 2) int32, that are marked, (n,) bool."""
    where = np.flatnonzero(keep)
    out = np.empty((len(where), 2), np.int32)
    _pick(pairs, where, out)
    return out


@njit(cache=True, parallel=True)
def _pick(pairs, where, out):
    for k in prange(len(where)):
        out[k, 0], out[k, 1] = pairs[where[k], 0], pairs[where[k], 1]


def key_of(segments: np.ndarray) -> np.ndarray:
    """Return one number per pair, in lexicographic order: first 2^32 + second, (n,) int64; pure."""
    pairs = segments.astype(np.int64)
    return (pairs[:, 0] << 32) | pairs[:, 1]


def renumbered(keys: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return those of sorted keys, (k,) int64, both of whose segments have a number, under these; pure.

    numbers  of all segments, ascending, -1 where there is none, (P,)
    """
    first = numbers[keys >> 32].astype(np.int64)
    second = numbers[keys & 0xFFFFFFFF].astype(np.int64)
    kept = (first >= 0) & (second >= 0)
    return (first[kept] << 32) | second[kept]


def measure(points: np.ndarray, segments: np.ndarray) -> Pairs:
    """Find where the segments of given pairs, (n, 2) int32, are closest; points [m], (P, 3); pure."""
    pairs = Pairs(segments, np.empty((len(segments), 2)), np.empty(len(segments)))
    _measure(points, *pairs)
    return pairs


@njit(cache=True, parallel=True)
def _measure(points, segments, fractions, distances):
    for k in prange(len(segments)):
        s, t, squared = closest_of(points, segments[k, 0], segments[k, 1])
        fractions[k, 0], fractions[k, 1], distances[k] = s, t, np.sqrt(squared)


class Known(NamedTuple):
    """Pairs that can be looked up.

    starts   the partners of segment i are seconds[starts[i] : starts[i + 1]], (P + 1,) int64
    seconds  the higher segment of each pair, (n,) int32
    """

    starts: np.ndarray
    seconds: np.ndarray


def known_pairs(keys: np.ndarray | None, points: int) -> Known:
    """Prepare sorted keys, (n,) int64, for look-up among the segments of so many points; pure."""
    keys = np.empty(0, np.int64) if keys is None else keys
    return _known(keys[: np.searchsorted(keys, points << 32)], points)


@njit(cache=True)
def _known(keys, points):
    starts = np.zeros(points + 1, np.int64)
    seconds = np.empty(len(keys), np.int32)
    for k in range(len(keys)):  # Keys are sorted by their first segment: its partners are already next to each other.
        starts[(keys[k] >> 32) + 1] += 1
        seconds[k] = keys[k] & 0xFFFFFFFF
    for i in range(points):
        starts[i + 1] += starts[i]
    return Known(starts, seconds)


@inlined
def is_known(known: Known, first: int, second: int) -> bool:
    """Whether a pair of segments, first < second, is among the known ones."""
    found = False
    if len(known.seconds) == 0:
        return found
    for k in range(known.starts[first], known.starts[first + 1]):
        found |= known.seconds[k] == second
    return found


@inlined
def mean_width(widths: np.ndarray, segments: np.ndarray, k: int) -> float:
    """Return how many times as far apart as two single hairs the segments of pair k are, by their widths, (P,)."""
    return 0.5 * (widths[segments[k, 0]] + widths[segments[k, 1]])


def within(
    pairs: Pairs, points: int, reach: float, ignored: np.ndarray, widths: np.ndarray | None = None
) -> np.ndarray:
    """Mark the pairs within reach [m] that are not ignored, (n,) bool; pure.

    points   their number; ignored  sorted keys, see `key_of`, (k,) int64
    widths   of segments: two of widths a and b may be (a + b) / 2 of the reach apart, (points,); None: 1
    """
    widths = np.ones(points) if widths is None else widths
    return _within(pairs.segments, pairs.distances, reach, known_pairs(ignored, points), widths)


@njit(cache=True, parallel=True)
def _within(segments, distances, reach, known, widths):
    keep = np.empty(len(distances), np.bool_)
    for k in prange(len(distances)):
        far = reach * mean_width(widths, segments, k)
        keep[k] = distances[k] <= far and not is_known(known, segments[k, 0], segments[k, 1])
    return keep
