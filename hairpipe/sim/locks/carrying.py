"""Followers, interpolated from neighbouring guides.

A point moves with the guide points that it follows,

    x = sum_j w_j (x_j + Q_j o_j),   w_j = 1 / max(|o_j|, core)^2 over their sum,

with x_j a point of a guide, Q_j its rotation since rest (`groom/keys/key_turns.py`) and o_j the offset from it when
the hair began to follow, rotated back to rest. So a rigid motion of hair stays rigid. Near the root the remaining
distance to the root is added. A hair is then smoothed where neighbouring points disagree, by the difference of its
bend from the bend when it began to follow, and its segment lengths are restored from the root on. Velocities are the
exact derivative, except in segments that have nearly collapsed.

The disagreement of a point, the rms distance of its predictions from their mean, estimates its error against a full
simulation: measured, the two have the same rms and a correlation of 0.7 to 0.85 over hairs (`measure_locks`).
"""

import numpy as np
from numba import njit, prange

from hairpipe.data.locks import Places
from hairpipe.groom.keys.interpolating import go_on, moved
from hairpipe.groom.keys.key_turns import turned
from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import cross, dot, length, minus, plus, row, scaled
from hairpipe.sim.locks.guides import GuideMotion
from hairpipe.sim.locks.places import turn_at
from hairpipe.sim.material import Material

_CORE = 3e-4
"""Nearer places count alike, for hair of the default diameter [m]: two hairs touch."""
_ROOT = 0.25
"""Share of a hair's length over which it goes from where its root is to where its guides take it."""
_PASSES = 2
"""Of smoothing."""
_SHORTEST = 0.5
"""Way over the length of its segment below which the segment turns no faster than the way would at this length."""


def interpolated(
    followers: np.ndarray,
    places: Places,
    guides: GuideMotion,
    offsets: np.ndarray,
    rest: np.ndarray,
    roots: tuple[np.ndarray, np.ndarray],
    diameter: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions and velocities of followers, (F, 3), and the disagreement of their guides, (n,); pure.

    followers  strands, ascending, (n,); places  places of their points, (F, ...)
    offsets    offsets of all strands, (S+1,) int32; rest  points of the groom [m], (P, 3), which define segment lengths
    roots      rigid motions of all roots, x -> R x + t, and their time derivatives, (S, 3, 4)
    diameter   of the hair [m]
    """
    points, velocities = np.empty((len(places.points), 3)), np.empty((len(places.points), 3))
    disagreement = np.empty(len(followers))
    begins = np.concatenate([[0], np.cumsum(np.diff(offsets)[followers])])
    owners = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets)).astype(np.int32)
    about = offsets, rest, owners, begins, _CORE * (diameter / Material().diameter)
    _interpolate(followers, places, guides, about, roots, points, velocities, disagreement)
    return points, velocities, disagreement


@njit(cache=True, parallel=True, error_model="numpy")
def _interpolate(followers, places, guides, about, roots, points, velocities, disagreement):
    offsets, rest, owners, begins, core = about
    motions, rates = roots
    for f in prange(len(followers)):
        begin = begins[f]
        end = begins[f + 1]
        first = offsets[followers[f]]
        x = points[begin:end]
        v = velocities[begin:end]
        total = 0.0
        for i in range(begin, end):
            total += _follow(places, guides, (owners, offsets, core), i, begin, x, v)
        disagreement[f] = np.sqrt(total / (end - begin))
        root, rate = moved(motions, followers[f], row(rest, first)), moved(rates, followers[f], row(rest, first))
        _lead_from_root(x, v, root, rate)
        for _ in range(_PASSES):
            _smooth(places, guides, owners, offsets, begin, x, v)
        for k in range(1, end - begin):
            l = length(minus(row(rest, first + k), row(rest, first + k - 1)))
            before, speed = row(x, k - 1), row(v, k - 1)
            way, change = minus(row(x, k), before), minus(row(v, k), speed)
            # A way that has nearly vanished, where places fold, turns at any speed: hair does not.
            change = scaled(min(length(way) / (_SHORTEST * l), 1.0), change)
            at, goes = go_on(before, speed, l, way, change)
            put(x, k, at)
            put(v, k, goes)


@njit(cache=True, error_model="numpy")
def _follow(places, guides, about, i, begin, x, v):
    """Put point i where its places take it; return the mean square of what they disagree by [m^2]."""
    owners, offsets, core = about
    weights, square = 0.0, 0.0
    there = to = speed = (0.0, 0.0, 0.0)
    for j in range(places.counts[i]):
        p = np.int64(places.points[i, j])
        offset = (
            np.float64(places.offsets[i, j, 0]),
            np.float64(places.offsets[i, j, 1]),
            np.float64(places.offsets[i, j, 2]),
        )
        k = turn_at(offsets, owners[p], p)
        way = turned(guides.turns, k, offset)
        y = plus(row(guides.points, p), way)
        dy = plus(row(guides.velocities, p), cross(row(guides.spins, k), way))
        if j == 0:  # Relative to the nearest: in squares of world coordinates the difference loses its digits.
            there = y
        w = 1.0 / max(dot(offset, offset), core * core)
        off = minus(y, there)
        weights = weights + w
        square = square + w * dot(off, off)
        to, speed = plus(to, scaled(w, off)), plus(speed, scaled(w, dy))
    mean = scaled(1.0 / weights, to)
    put(x, i - begin, plus(there, mean))
    put(v, i - begin, scaled(1.0 / weights, speed))
    return max(square / weights - dot(mean, mean), 0.0)  # Not negative: rounding of a variance.


@njit(cache=True)
def _lead_from_root(x, v, root, rate):
    """Shift a hair to its root, less and less along it, in place."""
    shift, change = minus(root, row(x, 0)), minus(rate, row(v, 0))
    for k in range(len(x)):
        left = max(1.0 - k / (_ROOT * (len(x) - 1)), 0.0)
        put(x, k, plus(row(x, k), scaled(left * left, shift)))
        put(v, k, plus(row(v, k), scaled(left * left, change)))


@njit(cache=True)
def _smooth(places, guides, owners, offsets, begin, x, v):
    """Move the points of a hair by a quarter of what its bends differ from those when it began to follow, in place."""
    last = len(x) - 1
    # Old places of the point before are kept, so that the result does not depend on the direction of the pass.
    before, went = row(x, 0), row(v, 0)
    for k in range(1, last + 1):
        i = begin + k
        here = row(x, k)
        goes = row(v, k)
        p = np.int64(places.points[i, 0])
        s = turn_at(offsets, owners[p], p)
        bend = (np.float64(places.bends[i, 0]), np.float64(places.bends[i, 1]), np.float64(places.bends[i, 2]))
        own = turned(guides.turns, s, bend)
        differs = minus(minus(before, here), own)
        turns = minus(minus(went, goes), cross(row(guides.spins, s), own))
        share = 0.5
        if k < last:
            differs, turns = plus(differs, minus(row(x, k + 1), here)), plus(turns, minus(row(v, k + 1), goes))
            share = 0.25
        put(x, k, plus(here, scaled(share, differs)))
        put(v, k, plus(goes, scaled(share, turns)))
        before, went = here, goes
