"""Guides chosen by the error of the hair that follows them, on sampled frames of a full simulation.

A strand that follows guide g has at frame f the segments Q_gf,k U_k, see `interpolating`, with U_k the segments of its
rest shape as guides rotate it. It is the mean direction of the segment in the frame of the guide,

    U_k = l_k m_k / |m_k|,   m_k = sum_f Q_gf,k^T t_f,k + a F T_k,

with t_f,k its segment at a frame, T_k that at rest, F the number of frames, and a small share a of the shape at rest.
The cost of the pair is the mean square of the distance over points and frames.

Guides minimise the sum of the costs of all strands, each with the guide of least cost: greedily (facility location,
with gains evaluated lazily, since they only fall), from strands that move rigidly with their roots. Then each guide is
replaced by the strand of least cost to all that have it, until none changes (k-medoids). A cost is a square: strays and
partings come first.

Finally each strand has up to three guides. Without the normalisation its points are linear in the weights w, and the
mean square is w^T A w, A_ij = r_i . r_j, with r_i the distances if it follows guide i alone. It is minimised for w >= 0
and sum w = 1 by exchanges between pairs, with one guide more at a time, in turn with the rest shape, for which sum w Q
replaces Q.
"""

import heapq
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, length, minus, mix, plus, put, row, scaled
from hairpipe.groom.interpolating import middle_among
from hairpipe.groom.key_weights import FOLLOWED, keys_among
from hairpipe.groom.keys import turned, turned_back, turns_since
from hairpipe.values import Groom, Guidance, Strands
from hairpipe.values.strand_arrays import at_shares

AT_REST = 0.1
"""Share of the shape at rest in that which guides rotate."""
CANDIDATES = 128
"""Strands among which a strand has its guide while guides are chosen."""
ALIKE, NEAR = 12, 6
"""Guides that move most alike, and guides with the nearest roots, of which a strand follows some."""
SHARES = (1.0 / 3.0, 2.0 / 3.0, 1.0)
"""Shares of the length at which motions are compared."""
MODES = 6  # principal components of displacements
OF_ROOTS = 1.0  # weight of the distance of roots, next to displacements
ROUNDS = 3  # of weights and rest shape, in turn
SWAPS = 10  # rounds in which guides are replaced, at most
EXCHANGES = 30  # rounds of exchanges of weights, at most
SMALLEST = 1e-4  # largest exchange of a round that ends them
_TINY = 1e-12

Roots = tuple[np.ndarray, np.ndarray]
"""Rigid motions of the roots of a groom and their rates, (S, 3, 4) each."""


class Motions(NamedTuple):
    """Hair at F sampled frames.

    ways   segments, from each point to the next; those of tips are unused [m], (F, P, 3) float32
    turns  rotations of the segments since rest, (F, P, 3, 3) float32
    away   displacements from rigid motion with the roots, at `SHARES` of the length [m], (S, 9 F)
    rigid  mean squares of these displacements over points and frames [m^2], (S,)
    """

    ways: np.ndarray
    turns: np.ndarray
    away: np.ndarray
    rigid: np.ndarray


def record_motions(groom: Groom, samples: Iterable[tuple[Strands, Roots]]) -> Motions:
    """Record the hair of a groom, and its roots, at sampled frames; pure."""
    ways, turns, away, squares = [], [], [], []
    count = len(groom.ids)
    strands = np.repeat(np.arange(count), len(SHARES))
    shares = np.tile(SHARES, count)
    for hair, (motions, rates) in samples:
        ways.append(np.diff(hair.points, axis=0, append=hair.points[-1:]).astype(np.float32))
        turns.append(turns_since(groom.points, hair, motions, rates).turns.astype(np.float32))
        own = np.repeat(motions, np.diff(groom.offsets), axis=0)
        rigid = np.einsum("pij,pj->pi", own[:, :, :3], groom.points) + own[:, :, 3]
        squares.append(mean_squares(hair.points - rigid, groom.offsets))
        away.append(at_shares(hair.points - rigid, groom.offsets, strands, shares).reshape(count, -1))
    return Motions(np.array(ways), np.array(turns), np.hstack(away), np.mean(squares, axis=0))


def mean_squares(distances: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the mean squares of distances, (P, 3), over the points of each strand but its root, (S,); pure."""
    squares = np.sum(distances**2, axis=1)
    squares[offsets[:-1]] = 0.0
    return np.add.reduceat(squares, offsets[:-1]) / (np.diff(offsets) - 1)


def farthest_roots(groom: Groom, count: int) -> np.ndarray:
    """Return strands whose roots are far from each other, (count,): each is the farthest from those before it. Pure."""
    roots = groom.points[groom.offsets[:-1]]
    chosen = [int(np.argmax(np.sum((roots - roots.mean(axis=0)) ** 2, axis=1)))]
    apart = np.sum((roots - roots[chosen[0]]) ** 2, axis=1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(apart)))
        apart = np.minimum(apart, np.sum((roots - roots[chosen[-1]]) ** 2, axis=1))
    return np.array(chosen)


class Choice:
    """The guides of a groom, of any number, that minimise the cost of all strands at sampled frames."""

    def __init__(self, groom: Groom, motions: Motions) -> None:
        count = len(groom.ids)
        self._motions = motions
        among = _features(groom, motions.away, _basis(motions.away))
        self._near = _nearest(among, among, min(CANDIDATES, count))
        self._costs = np.empty(self._near.shape)
        hair = _Hair(motions.ways, _segments(groom), groom.offsets)
        _pair_costs(hair, self._near, _Keys(motions.turns, groom.offsets), self._costs)
        self._costs[self._near == np.arange(count)[:, None]] = 0.0
        # The strands that have each strand among their candidates, as runs of one list.
        order = np.argsort(self._near, axis=None, kind="stable")
        self._users = order // self._near.shape[1]
        self._used = self._costs.ravel()[order]
        self._runs = np.searchsorted(self._near.ravel()[order], np.arange(count + 1))
        self._order: list[int] = []
        self._left = motions.rigid.copy()
        self._gains = [(-self._gain(g), g) for g in range(count)]
        heapq.heapify(self._gains)

    def _gain(self, guide: int) -> float:
        run = slice(self._runs[guide], self._runs[guide + 1])
        return float(np.maximum(self._left[self._users[run]] - self._used[run], 0.0).sum())

    def guides(self, count: int) -> np.ndarray:
        """Return so many strands as guides, ascending, (count,) int64."""
        while len(self._order) < count:
            _, guide = heapq.heappop(self._gains)
            gain = self._gain(guide)
            if self._gains and -self._gains[0][0] > gain:
                heapq.heappush(self._gains, (-gain, guide))
                continue
            self._order.append(guide)
            run = slice(self._runs[guide], self._runs[guide + 1])
            np.minimum.at(self._left, self._users[run], self._used[run])
        chosen = np.array(self._order[:count])
        for _ in range(SWAPS):
            moved = self._medoids(chosen)
            if np.array_equal(moved, chosen):
                break
            chosen = moved
        return np.sort(chosen)

    def _medoids(self, chosen: np.ndarray) -> np.ndarray:
        """Return for each guide, (n,), the strand of least cost to all strands that have it, (n,)."""
        place = np.full(len(self._near), -1)
        place[chosen] = np.arange(len(chosen))
        costs = np.where(place[self._near] >= 0, self._costs, np.inf)
        best = np.argmin(costs, axis=1)
        rows = np.arange(len(best))
        guide = np.where(np.isfinite(costs[rows, best]), place[self._near[rows, best]], -1)
        # A strand costs what it does as a candidate, and its rigid motion where it has not this one.
        saved = np.minimum(self._costs - self._motions.rigid[:, None], 0.0) * (guide[self._near] == guide[:, None])
        totals = np.bincount(self._near.ravel(), saved.ravel(), minlength=len(best))
        order = np.lexsort((totals, guide))
        return order[np.searchsorted(guide[order], np.arange(len(chosen)))]


def _basis(away: np.ndarray) -> np.ndarray:
    # The principal components of displacements, (S, n), as columns, (n, up to MODES).
    centred = away - away.mean(axis=0)
    return np.linalg.eigh(centred.T @ centred)[1][:, -MODES:]


def _features(groom: Groom, away: np.ndarray, basis: np.ndarray) -> np.ndarray:
    # What strands are compared by: displacements in a basis, and roots, which count as one point a sample.
    roots = groom.points[groom.offsets[:-1]]
    return np.hstack([away @ basis, OF_ROOTS * np.sqrt(away.shape[1] / 3.0) * roots])


def _nearest(places: np.ndarray, others: np.ndarray, count: int) -> np.ndarray:
    # Which of the others are nearest to each place, the nearest first, (S, count).
    from scipy.spatial import KDTree

    return np.asarray(KDTree(others).query(places, k=count)[1], np.int64).reshape(len(places), -1)


def _segments(groom: Groom) -> np.ndarray:
    return np.diff(groom.points, axis=0, append=groom.points[-1:])


def fit_guidance(groom: Groom, motions: Motions, keys: Groom, turns: Motions) -> Guidance:
    """Fit guides of every strand, their weights, and the rest shape that they rotate, to sampled frames; pure.

    A guide follows itself, with its own shape.

    motions  those of the groom; turns: those of the keys at the same frames
    """
    basis = _basis(motions.away)
    alike = _nearest(
        _features(groom, motions.away, basis), _features(keys, turns.away, basis), min(ALIKE, len(keys.ids))
    )
    ours, theirs = (some.points[some.offsets[:-1]] for some in (groom, keys))
    near = _nearest(ours, theirs, min(NEAR, len(keys.ids)))
    near[(near[:, :, None] == alike[:, None, :]).any(axis=2)] = -1  # A guide is a candidate once.
    found = np.zeros((len(groom.ids), FOLLOWED), np.int64)
    weights = np.zeros((len(groom.ids), FOLLOWED))
    shapes = _segments(groom)
    hair = _Hair(motions.ways, _segments(groom), groom.offsets)
    _fit(hair, np.hstack([alike, near]), _Keys(turns.turns, keys.offsets), found, weights, shapes)
    own = keys_among(groom, keys)
    itself = own >= 0
    found[itself] = own[itself, None]
    weights[itself] = (1.0, 0.0, 0.0)
    points = np.repeat(itself, np.diff(groom.offsets))
    shapes[points] = _segments(groom)[points]
    shapes[groom.offsets[1:] - 1] = 0.0
    along = np.concatenate([np.zeros((1, 3)), np.cumsum(shapes, axis=0)[:-1]])
    roots = groom.offsets[:-1]
    rest = along + np.repeat(groom.points[roots] - along[roots], np.diff(groom.offsets), axis=0)
    rest[roots] = groom.points[roots]
    order = np.argsort(-weights, axis=1, kind="stable")
    ids = keys.ids[np.take_along_axis(found, order, axis=1)]
    return Guidance(ids, np.take_along_axis(weights, order, axis=1).astype(np.float32), rest)


@inlined
def _rotated(turns: np.ndarray, first: int, theirs: int, k: int, segments: int, v: Vector, back: bool) -> Vector:
    # A vector as a guide turns segment k of a hair, or its inverse; between the middles of two segments both do.
    below, rest = middle_among(k, segments, theirs)
    t = turned_back(turns, first + below, v) if back else turned(turns, first + below, v)
    if rest > 0.0:
        other = turned_back(turns, first + below + 1, v) if back else turned(turns, first + below + 1, v)
        t = mix(t, other, rest)
    return t


class _Hair(NamedTuple):
    """Segments of strands at frames and at rest, [m], (F, P, 3) float32 and (P, 3); offsets of their points."""

    ways: np.ndarray
    shapes: np.ndarray
    offsets: np.ndarray


class _Keys(NamedTuple):
    """Rotations of segments of keys at the same frames, (F, K, 3, 3) float32; offsets of their points."""

    turns: np.ndarray
    offsets: np.ndarray


@njit(cache=True, error_model="numpy")
def _fit_shape(hair: _Hair, s: int, guides: np.ndarray, weights: np.ndarray, keys: _Keys, shape: np.ndarray) -> None:
    """Write the rest shape of a strand that guides, (n,), rotate, (segments, 3) [m]."""
    ways, shapes, offsets = hair
    turns, firsts = keys
    begin = offsets[s]
    segments = offsets[s + 1] - begin - 1
    frames = len(ways)
    for k in range(segments):
        put(shape, k, scaled(AT_REST * frames, row(shapes, begin + k)))
    for f in range(frames):
        for j in range(len(guides)):
            if weights[j] > 0.0:
                first = firsts[guides[j]]
                theirs = firsts[guides[j] + 1] - first - 1
                for k in range(segments):
                    t = _rotated(turns[f], first, theirs, k, segments, row(ways[f], begin + k), True)
                    put(shape, k, plus(row(shape, k), scaled(weights[j], t)))
    for k in range(segments):
        T = row(shapes, begin + k)
        size = length(row(shape, k))
        put(shape, k, scaled(length(T) / size, row(shape, k)) if size > _TINY * length(T) else T)


@njit(cache=True, error_model="numpy")
def _distances(hair: _Hair, s: int, guide: int, keys: _Keys, shape: np.ndarray, found: np.ndarray) -> None:
    """Write the distances of points of a strand that follows one guide, at all frames [m], (F segments 3,)."""
    ways, _, offsets = hair
    turns, firsts = keys
    begin = offsets[s]
    segments = offsets[s + 1] - begin - 1
    first = firsts[guide]
    theirs = firsts[guide + 1] - first - 1
    i = 0
    for f in range(len(ways)):
        x = (0.0, 0.0, 0.0)
        for k in range(segments):
            t = _rotated(turns[f], first, theirs, k, segments, row(shape, k), False)
            x = plus(x, minus(t, row(ways[f], begin + k)))
            found[i], found[i + 1], found[i + 2] = x
            i += 3


@njit(cache=True, error_model="numpy")
def _product(a: np.ndarray, b: np.ndarray) -> float:
    # In order: the sums of linear algebra depend on the processor.
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@njit(cache=True, parallel=True, error_model="numpy")
def _pair_costs(hair: _Hair, near: np.ndarray, keys: _Keys, costs: np.ndarray) -> None:
    """Write the cost of each candidate of every strand [m^2], (S, C)."""
    frames = len(hair.ways)
    one = np.ones(1)
    for s in prange(len(near)):
        segments = hair.offsets[s + 1] - hair.offsets[s] - 1
        shape = np.empty((segments, 3))
        found = np.empty(3 * frames * segments)
        for c in range(near.shape[1]):
            _fit_shape(hair, s, near[s, c : c + 1], one, keys, shape)
            _distances(hair, s, near[s, c], keys, shape, found)
            costs[s, c] = _product(found, found) / (frames * segments)


@njit(cache=True, error_model="numpy")
def _exchange(A: np.ndarray, chosen: np.ndarray, w: np.ndarray) -> float:
    """Minimise w^T A w over weights of chosen candidates, (m,), in place; return the minimum."""
    count = len(chosen)
    for _ in range(EXCHANGES):
        largest = 0.0
        for a in range(count):
            for b in range(count):
                i, j = chosen[a], chosen[b]
                slope = 0.0
                for c in range(count):
                    slope += (A[i, chosen[c]] - A[j, chosen[c]]) * w[c]
                bend = A[i, i] + A[j, j] - 2.0 * A[i, j]
                if slope > 0.0 and bend > 0.0:
                    step = min(slope / bend, w[a])
                    w[a] -= step
                    w[b] += step
                    largest = max(largest, step)
        if largest < SMALLEST:
            break
    total = 0.0
    for a in range(count):
        for b in range(count):
            total += w[a] * w[b] * A[chosen[a], chosen[b]]
    return total


@njit(cache=True, error_model="numpy")
def _choose(A: np.ndarray, usable: np.ndarray, chosen: np.ndarray, weights: np.ndarray) -> None:
    """Write the candidates that a strand follows, with their weights, one more at a time, while that helps."""
    weights[:] = 0.0
    least = np.inf
    for m in range(len(chosen)):
        best = -1
        trial = weights.copy()
        kept = weights.copy()
        for c in range(len(A)):
            if not usable[c] or (chosen[:m] == c).any():
                continue
            chosen[m] = c
            trial[:] = weights
            if m == 0:
                trial[0] = 1.0
            total = _exchange(A, chosen[: m + 1], trial[: m + 1])
            if total < least:
                least, best = total, c
                kept[:] = trial
        chosen[m] = best if best >= 0 else chosen[0]
        if best < 0:
            chosen[m:] = chosen[0]
            return
        weights[:] = kept


@njit(cache=True, parallel=True, error_model="numpy")
def _fit(
    hair: _Hair, near: np.ndarray, keys: _Keys, followed: np.ndarray, weights: np.ndarray, fitted: np.ndarray
) -> None:
    """Write keys and weights, (S, FOLLOWED), and the segments of rest shapes, (P, 3); candidates below 0 are none."""
    count = near.shape[1]
    one = np.ones(1)
    for s in prange(len(near)):
        begin = hair.offsets[s]
        segments = hair.offsets[s + 1] - begin - 1
        shape = fitted[begin : begin + segments]
        found = np.empty((count, 3 * len(hair.ways) * segments))
        A = np.empty((count, count))
        chosen = np.zeros(FOLLOWED, np.int64)
        best = 0
        least = np.inf
        for c in range(count):
            if near[s, c] >= 0:
                _fit_shape(hair, s, near[s, c : c + 1], one, keys, shape)
                _distances(hair, s, near[s, c], keys, shape, found[c])
                total = _product(found[c], found[c])
                if total < least:
                    best, least = c, total
        _fit_shape(hair, s, near[s, best : best + 1], one, keys, shape)
        for _ in range(ROUNDS):
            for c in range(count):
                if near[s, c] >= 0:
                    _distances(hair, s, near[s, c], keys, shape, found[c])
                else:
                    found[c] = 0.0
            for a in range(count):
                for b in range(a + 1):
                    A[a, b] = A[b, a] = _product(found[a], found[b])
            _choose(A, near[s] >= 0, chosen, weights[s])
            for j in range(FOLLOWED):
                followed[s, j] = near[s, chosen[j]]
            _fit_shape(hair, s, followed[s], weights[s], keys, shape)
