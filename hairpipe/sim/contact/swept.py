"""Pairs of segments that may come near each other within a step."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.body.vectors import dot, times
from hairpipe.sim.contact.distances import fastest_squared, squared_distances
from hairpipe.sim.contact.drift import Drift, departures, find_drift
from hairpipe.sim.contact.found import CHUNK, gather_pairs, in_order, note
from hairpipe.sim.contact.grid import (
    LANES,
    MOST_RUNS,
    SINGLE,
    ULP,
    Grid,
    build_grid,
    entry,
    find_runs,
    reaching,
    rounding,
)
from hairpipe.sim.contact.pairs import Known, known_pairs
from hairpipe.sim.contact.pieces import Pieces, all_segments, cut_in_pieces, piece, pieces_of, refuse_lost
from hairpipe.sim.lanes import any_lane, bits, lowest, sqrt

_CALM = 0.25
"""Departure from the common motion, over the longest piece, that is sorted into the first level."""
_STEP = 4.0
"""From level to level."""
_SAMPLE = 4096


class Motion(NamedTuple):
    """How the pieces of a grid at half time move that depart about equally from the common motion of all.

    drift  for every piece x y z of the displacement of its start in half a step and x y z of that of its end, in cells,
           (6, E + LANES) float32
    away   by how much each departs from the common motion in half a step [m], (E,)
    most   of these [m]
    """

    drift: np.ndarray
    away: np.ndarray
    most: float


Level = tuple[Grid, Motion]


class Neighbourhood(NamedTuple):
    """Hair in a step, ready to be searched.

    levels  pieces of segments that depart about equally from the common motion, common
    centre  amid the points at half time [m], (3,)
    frame   displacement in half a step that is taken from that of all points [m], (3,)
    points  number of them
    """

    levels: list[Level]
    common: Drift
    centre: np.ndarray
    frame: np.ndarray
    points: int


def neighbourhood(before: np.ndarray, after: np.ndarray, offsets: np.ndarray, reach: float) -> Neighbourhood:
    """Sort all segments for searches in a linear motion; pure.

    before, after  positions [m], (P, 3) float64
    offsets        strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    reach          that it suits best [m]

    Raises ArithmeticError where a position is not finite.
    """
    refuse_lost(before)
    refuse_lost(after)
    segments = all_segments(len(before), offsets)
    some = slice(None, None, max(1, len(before) // _SAMPLE))
    sample = _halves(before[some].copy(), after[some].copy(), np.zeros(3))
    centre, frame = (np.median(x, axis=0) if len(x) else np.zeros(3) for x in sample)
    middle, half = _halves(before, after, frame)
    common = find_drift(middle, half)
    return Neighbourhood(_levels(middle, half, segments, common, reach, centre), common, centre, frame, len(before))


def swept_pairs(around: Neighbourhood, reach: float, ignored: np.ndarray | None = None) -> np.ndarray:
    """List all pairs of segments that get within reach [m] in a motion, and some others, (n, 2) int32; pure.

    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64

    In order, first < second; the two share no point. Two segments get nearer than at half time, d, by no more than
    half the largest relative displacement D of their ends: kept are pairs with d <= reach + D / 2. What departs little
    from the motion of its surroundings is searched apart from what is fast, see `drift`.
    """
    known = known_pairs(ignored, around.points)
    found = [
        _meetings(*sorted((level, other), key=lambda one: len(one[1].away)), reach, around.common.steep, known)
        for k, level in enumerate(around.levels)
        for other in around.levels[k:]
    ]
    return in_order(np.concatenate([np.empty((0, 2), np.int32), *found]), around.points)


def swept_pairs_of(
    around: Neighbourhood,
    segments: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    reach: float,
    ignored: np.ndarray | None = None,
) -> np.ndarray:
    """List the pairs with one of some segments, (m,) int32, ascending, that move otherwise than they did; pure.

    around  hair as it moved; before, after  as it moves now [m], (P, 3) float64

    Of two of these segments both as they move now; the others as they moved. Otherwise as `swept_pairs`.
    """
    known = known_pairs(ignored, len(before))
    middle, half = _halves(before, after, around.frame)
    mine = _levels(middle, half, segments, around.common, reach, around.centre)
    found = [
        _meetings(level, other, reach, around.common.steep, known)
        for k, level in enumerate(mine)
        for other in [*mine[k:], *around.levels]
    ]
    return in_order(np.concatenate([np.empty((0, 2), np.int32), *found]), len(before))


@njit(cache=True, parallel=True)
def _halves(before, after, frame):  # noqa: ANN001, ANN202
    """Return positions at half time, and displacements in half a step beyond that of a frame, (P, 3) each."""
    middle, half = np.empty_like(before), np.empty_like(before)
    for k in prange(len(before)):
        for c in range(3):
            middle[k, c] = 0.5 * (before[k, c] + after[k, c])
            half[k, c] = 0.5 * (after[k, c] - before[k, c]) - frame[c]
    return middle, half


def _levels(
    middle: np.ndarray, half: np.ndarray, segments: np.ndarray, common: Drift, reach: float, centre: np.ndarray
) -> list[Level]:
    pieces = cut_in_pieces(middle, segments, reach)
    away = departures(common, middle, half, pieces)
    return [_build_level(middle, half, *some, reach, centre) for some in _by_departure(pieces, away)]


def _by_departure(pieces: Pieces, away: np.ndarray) -> list[tuple[Pieces, np.ndarray]]:
    """Sort pieces into levels, each of which departs up to _STEP times as far as the one before."""
    levels = _levels_of(away, _CALM * max(pieces.longest, 1e-9))
    members = [np.flatnonzero(levels == level) for level in np.flatnonzero(np.bincount(levels))]
    if len(members) == 1:
        return [(pieces, away)]
    return [(pieces._replace(segments=pieces.segments[k], numbers=pieces.numbers[k]), away[k]) for k in members]


@njit(cache=True, parallel=True)
def _levels_of(away, calm):  # noqa: ANN001, ANN202
    """Count by how many factors of _STEP pieces depart farther than what is calm, (E,) int8."""
    levels = np.empty(len(away), np.int8)
    for e in prange(len(away)):
        level, bound = 0, calm
        while away[e] > bound:
            level, bound = level + 1, bound * _STEP
        levels[e] = level
    return levels


def _build_level(
    middle: np.ndarray, half: np.ndarray, pieces: Pieces, away: np.ndarray, reach: float, centre: np.ndarray
) -> Level:
    most = float(away.max())
    grid = build_grid(middle, pieces, reach + 2.0 * most, centre)
    drift = np.zeros((6, len(away) + LANES), SINGLE)
    _fill_drift(middle, half, grid, drift)
    return grid, Motion(drift, away[grid.order], most)


@njit(cache=True, parallel=True)
def _fill_drift(middle, half, grid, drift):  # noqa: ANN001, ANN202
    for e in prange(len(grid.segments)):
        i = grid.segments[e]
        u, v = piece(half, i, grid.numbers[e], pieces_of(middle, i, grid.cut))
        for x in range(3):
            drift[x, e], drift[3 + x, e] = u[x] / grid.cell, v[x] / grid.cell


def _meetings(few: Level, many: Level, reach: float, steep: float, known: Known) -> np.ndarray:
    """List which pieces of one level may meet which of another one, or of the same."""

    def search(*out: np.ndarray) -> None:
        _search(*few, *many, few is many, reach, 1.0 / (1.0 - steep), known, *out)

    return gather_pairs(search, len(few[1].away))


@njit(cache=True, parallel=True)
def _search(some, few, grid, many, same, reach, stretch, known, chunks, starts, found, counts):  # noqa: ANN001, ANN202
    for k in prange(len(chunks)):
        runs = np.empty((MOST_RUNS, 2), np.int64)
        out = found[starts[k] : starts[k + 1]]
        counts[k] = _search_chunk(some, few, grid, many, same, reach, stretch, known, np.int64(chunks[k]), runs, out)


@inlined
def _search_chunk(some, few, grid, many, same, reach, stretch, known, chunk, runs, found):  # noqa: ANN001, ANN202
    """Write to found what pieces of a chunk of one level may meet in another, or after them in the same; count it."""
    count = 0
    for e in range(chunk * CHUNK, min((chunk + 1) * CHUNK, len(few.away))):
        p, d, dd, inverse, u, v = _entry(some, few.drift, e, grid.cell)
        radius = (reach + few.away[e] + many.most) * stretch / grid.cell
        blur, excess = rounding(p, radius + grid.half, grid.half + 0.5 * np.sqrt(dd))
        blur += _drift_rounding(u, v)
        farthest = SINGLE(((radius + blur) ** 2 + excess) * (1.0 + 1e-6))
        low, high = reaching(p, d, radius + grid.half + blur)
        margin, excess = SINGLE(reach / grid.cell + blur), SINGLE(excess)
        for r in range(find_runs(grid, low, high, e + 1 if same else 0, runs)):
            for start in range(runs[r, 0], runs[r, 1], LANES):
                squared = squared_distances(grid.rows, p, d, dd, inverse, start)
                if not any_lane(squared <= farthest):
                    continue
                gain = sqrt(fastest_squared(many.drift, u, v, start)) * SINGLE(1.0 + 1e-5) + margin
                near = bits(squared <= farthest) & bits(squared <= gain * gain + excess)
                near &= (1 << min(runs[r, 1] - start, LANES)) - 1
                while near != 0:
                    other = grid.segments[start + lowest(near)]
                    near &= near - 1
                    count += note(some.segments[e], other, known, found, count)
    return count


@inlined
def _entry(grid, drift, e, cell):  # noqa: ANN001, ANN202
    """Return a piece as `entry` does and the displacements of its ends, in cells of another grid."""
    p, d, _, _ = entry(grid, e)
    u, v = (drift[0, e], drift[1, e], drift[2, e]), (drift[3, e], drift[4, e], drift[5, e])
    scale = grid.cell / cell
    p, d, u, v = times(scale, p), times(scale, d), times(scale, u), times(scale, v)
    dd = dot(d, d)
    return p, d, dd, 1.0 / dd if dd > 0.0 else 0.0, u, v


@inlined
def _drift_rounding(u, v):  # noqa: ANN001, ANN202
    """Bound how displacements relative to u and v are rounded, but for a small part of themselves."""
    largest = max(abs(u[0]), max(abs(u[1]), abs(u[2]))) + max(abs(v[0]), max(abs(v[1]), abs(v[2])))
    return 16.0 * ULP * largest
