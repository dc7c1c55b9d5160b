"""Segments to search among, the longest of them in pieces, so that one that is overlong does not slow all others."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.body.vectors import Vector, length, minus, mix, row

FARTHEST = 1e12
"""Coordinates beyond this [m] are refused."""
_OVERLONG = 2.0
"""Length over that of half of all segments from which on a segment is cut."""
_MOST_PIECES = 4
"""Pieces over segments."""
_SAMPLE = 1024


class Pieces(NamedTuple):
    """Segments and pieces of them.

    segments  that each is a piece of, ascending, (E,) int32
    numbers   of the piece in its segment, ascending from 0, (E,) int32
    cut       segments longer than this are in pieces [m]
    longest   of the pieces [m]
    """

    segments: np.ndarray
    numbers: np.ndarray
    cut: float
    longest: float


def all_segments(points: int, offsets: np.ndarray) -> np.ndarray:
    """List the segments of all strands of so many points, (m,) int32, ascending; pure."""
    is_segment = np.ones(points, bool)
    is_segment[offsets[1:][offsets[1:] > offsets[:-1]] - 1] = False
    return np.flatnonzero(is_segment).astype(np.int32)


def refuse_lost(points: np.ndarray) -> None:
    """Raise ArithmeticError where a position [m], (P, 3), is not finite, or farther from 0 than a light-hour."""
    lost = np.empty(len(points), np.bool_)
    _find_lost(points, lost)
    if lost.any():
        where = int(np.argmax(lost))
        raise ArithmeticError(f"point {where} of the hair is at {points[where]} m")


@njit(cache=True, parallel=True)
def _find_lost(points, lost):  # noqa: ANN001, ANN202
    for k in prange(len(points)):
        x, y, z = row(points, k)
        lost[k] = not max(abs(x), max(abs(y), abs(z))) <= FARTHEST or x != x or y != y or z != z


def cut_in_pieces(points: np.ndarray, segments: np.ndarray, reach: float) -> Pieces:
    """Cut the segments, (m,) int32, that are far longer than most and than reach [m]; points [m], (P, 3); pure."""
    lengths = np.empty(len(segments))
    _measure(points, segments, lengths)
    typical = float(np.median(lengths[:: max(1, len(lengths) // _SAMPLE)])) if len(lengths) else 0.0
    longest = float(lengths.max(initial=0.0))
    cut = max(_OVERLONG * typical, reach, longest / (_MOST_PIECES * max(1, len(segments))))
    if longest <= cut:
        return Pieces(segments, np.zeros(len(segments), np.int32), cut, longest)
    counts = np.empty(len(segments), np.int64)
    _count(lengths, cut, counts)
    while counts.sum() > _MOST_PIECES * len(segments):
        cut *= 2.0
        _count(lengths, cut, counts)
    starts = np.cumsum(counts) - counts
    numbers = np.arange(counts.sum()) - np.repeat(starts, counts)
    return Pieces(np.repeat(segments, counts), numbers.astype(np.int32), cut, float((lengths / counts).max()))


@njit(cache=True, parallel=True)
def _measure(points, segments, lengths):  # noqa: ANN001, ANN202
    for k in prange(len(segments)):
        i = segments[k]
        lengths[k] = length(minus(row(points, i + 1), row(points, i)))


@njit(cache=True)
def _count(lengths, cut, counts):  # noqa: ANN001, ANN202
    for k in range(len(lengths)):
        counts[k] = _pieces(lengths[k], cut)


@inlined
def _pieces(size: float, cut: float) -> int:
    return int(np.ceil(size / cut)) if size > cut else 1


@inlined
def pieces_of(points: np.ndarray, i: int, cut: float) -> int:
    """Return in how many pieces segment i is cut."""
    return _pieces(length(minus(row(points, i + 1), row(points, i))), cut)


@inlined
def piece(points: np.ndarray, i: int, number: int, count: int) -> tuple[Vector, Vector]:
    """Return the ends [m] of a piece of segment i."""
    a, b = row(points, i), row(points, i + 1)
    if count == 1:
        return a, b
    return mix(a, b, number / count), mix(a, b, (number + 1) / count)
