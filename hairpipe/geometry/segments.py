"""The segments of strands, pairs of them, sorted lists in which a pair is looked up, and the check for lost points."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segment_distance import closest_of
from hairpipe.geometry.sorting import places_of, rows_at, runs_of
from hairpipe.geometry.vec3 import row

FARTHEST = 1e12
"""Coordinates beyond this [m] are refused."""

TOUCHING = 1e-6
"""Distance over the lengths of both segments."""


def all_segments(offsets: np.ndarray) -> np.ndarray:
    """List the segments of all strands, whose points are offsets[s] : offsets[s + 1], (m,) int32, ascending; pure."""
    counts = np.maximum(np.diff(offsets) - 1, 0)
    ends = np.cumsum(counts)
    segments = np.empty(counts.sum(), np.int32)
    _list(offsets, ends - counts, ends, segments)
    return segments


@njit(cache=True, parallel=True)
def _list(offsets, starts, ends, segments):
    for strand in prange(len(starts)):
        for k in range(starts[strand], ends[strand]):
            segments[k] = offsets[strand] + k - starts[strand]


class LostPoints(ArithmeticError):
    """Points, (n,) int64, are not finite, or farther away than a light-hour."""

    def __init__(self, points: np.ndarray) -> None:
        super().__init__(f"{len(points)} points of the hair are not finite, the first is number {points[0]}")
        self.points = points


def refuse_lost(points: np.ndarray) -> None:
    """Raise LostPoints where positions [m], (P, 3), are."""
    lost = np.empty(len(points), np.bool_)
    if _find_lost(points, lost):
        raise LostPoints(np.flatnonzero(lost))


@njit(cache=True, parallel=True)
def _find_lost(points, lost):
    """Mark what is lost, in place; return the number of marks."""
    count = 0
    for k in prange(len(points)):
        x, y, z = row(points, k)
        # max may drop a NaN, depending on the order of its arguments: each is tested for itself, too.
        lost[k] = not max(abs(x), max(abs(y), abs(z))) <= FARTHEST or x != x or y != y or z != z
        count += lost[k]
    return count


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
    places = places_of(keep)
    return pairs if len(places) == len(keep) else Pairs(*(rows_at(field, places) for field in pairs))


def key_of(segments: np.ndarray) -> np.ndarray:
    """Return one number per pair, in lexicographic order: first 2^32 + second, (n,) int64; pure."""
    keys = np.empty(len(segments), np.int64)
    _find_keys(np.ascontiguousarray(segments, np.int32), keys)
    return keys


@njit(cache=True, parallel=True)
def _find_keys(segments, keys):
    for k in prange(len(keys)):
        keys[k] = np.int64(segments[k, 0]) << 32 | np.int64(segments[k, 1])


def renumbered(keys: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return those of sorted keys, (k,) int64, both of whose segments have a number, under these; pure.

    numbers  of all segments, ascending, -1 where there is none, (P,)
    """
    first = numbers[keys >> 32].astype(np.int64)
    second = numbers[keys & 0xFFFFFFFF].astype(np.int64)
    kept = (first >= 0) & (second >= 0)
    return (first[kept] << 32) | second[kept]


@njit(cache=True, parallel=True)
def measure(points: np.ndarray, segments: np.ndarray) -> Pairs:
    """Find where the segments of given pairs, (n, 2) int32, are closest; points [m], (P, 3); pure."""
    fractions = np.empty((len(segments), 2))
    distances = np.empty(len(segments))
    for k in prange(len(segments)):
        s, t, squared = closest_of(points, segments[k, 0], segments[k, 1])
        fractions[k, 0] = s
        fractions[k, 1] = t
        distances[k] = np.sqrt(squared)
    return Pairs(segments, fractions, distances)


class Known(NamedTuple):
    """Pairs that can be looked up.

    starts  pairs whose lower segment is i are keys[starts[i] : starts[i + 1]], (P + 1,) int32
    keys    sorted, see `key_of`, (n,) int64
    """

    starts: np.ndarray
    keys: np.ndarray


def known_pairs(keys: np.ndarray | None, points: int) -> Known:
    """Prepare sorted keys, (n,) int64, for look-up among the segments of so many points; pure."""
    keys = np.empty(0, np.int64) if keys is None else keys
    keys = keys[: np.searchsorted(keys, points << 32)]
    return Known(runs_of(keys, points), keys)


@inlined
def is_known(known: Known, first: int, second: int) -> bool:
    """Whether a pair of segments, first < second, is among the known ones."""
    found = False
    if len(known.keys) == 0:
        return found
    for k in range(known.starts[first], known.starts[first + 1]):
        found |= known.keys[k] & 0xFFFFFFFF == second
    return found


@inlined
def mean_width(widths: np.ndarray, segments: np.ndarray, k: int) -> float:
    """Return how many times as far apart as two single hairs the segments of pair k are, by their widths, (P,)."""
    return 0.5 * (widths[segments[k, 0]] + widths[segments[k, 1]])


def within(
    pairs: Pairs, points: int, reach: float, ignored: np.ndarray | None, widths: np.ndarray | None = None
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


def ages_of(before: np.ndarray, places: np.ndarray, ages: np.ndarray, now: np.ndarray, here: np.ndarray) -> np.ndarray:
    """Return the ages of connections in frames, (m,) int32; pure.

    before, places, ages  previous frame: segments, sorted by `key_of`, (n, 2) int32, positions on them, (n, 2), and
                          ages in frames, (n,) int32
    now, here             segments and positions at this frame, (m, 2): a changed position is a new connection
    """
    if not len(before):
        return np.zeros(len(now), np.int32)
    keys = key_of(before)
    found = np.minimum(np.searchsorted(keys, key_of(now)), len(keys) - 1)
    same = (keys[found] == key_of(now)) & (places[found] == here).all(axis=1)
    return np.where(same, ages[found] + 1, 0).astype(np.int32)
