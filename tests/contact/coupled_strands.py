"""Strands that are coupled anywhere, and the same couplings as one dense matrix."""

import numpy as np

from hairpipe.geometry.simd_vec4 import WHOLE
from hairpipe.solve.couplings import Couplings, matrices

OFFSETS = np.cumsum([0, 2, 5, 9, 3, 1800, 700]).astype(np.int32)
"""Of points of strands; together more than one chunk of any kernel."""


def segments_of(offsets):
    """Every segment of every strand."""
    return np.setdiff1d(np.arange(offsets[-1]), offsets[1:] - 1).astype(np.int32)


def square(six):
    """A symmetric matrix from xx xy xz yy yz zz."""
    return np.asarray(six)[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3)


def whole_matrix(couplings, points):
    """The sum of J^T M J, (3 points, 3 points)."""
    whole = np.zeros((points, 3, points, 3))
    for (a, b), (s, t), M in zip(couplings.segments, couplings.fractions, matrices(couplings), strict=True):
        weights = {a: 1 - s, a + 1: s}
        for place, weight in ((b, t - 1), (b + 1, -t)):  # neighbours of one strand share a point
            weights[place] = weights.get(place, 0.0) + weight
        for one, first in weights.items():
            for other, second in weights.items():
                whole[one, :, other] += first * second * M
    return whole.reshape(3 * points, 3 * points)


def own_matrix(diagonal, following):
    """Own blocks, as one matrix (3 points, 3 points)."""
    points = len(diagonal)
    A = np.zeros((3 * points, 3 * points))
    for k in range(points):
        A[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = square(diagonal[k])
        if k + 1 < points:
            A[3 * k : 3 * k + 3, 3 * k + 3 : 3 * k + 6] = square(following[k])
            A[3 * k + 3 : 3 * k + 6, 3 * k : 3 * k + 3] = square(following[k])
    return A


def random_couplings(offsets, count, seed=0):
    """Couplings between random segments, neighbours of one strand among them, most of which act.

    Their numbers are as precise as kernels keep them.
    """
    rng = np.random.default_rng(seed)
    candidates = segments_of(offsets)
    pairs = np.sort(np.stack([rng.choice(candidates, 2, replace=False) for _ in range(count)]), axis=1)
    pairs[:3] = [[candidates[-2], candidates[-1]], [candidates[1], candidates[2]], [candidates[0], candidates[-1]]]
    fractions = rng.random((count, 2))
    fractions[3:5] = [[0.0, 1.0], [1.0, 0.0]]
    d = rng.normal(size=(count, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    acts, push = rng.random(count) < 0.9, rng.normal(size=(count, 3))
    kept = np.rint(fractions * WHOLE) / WHOLE, np.trunc(d * WHOLE) / WHOLE
    strength = rng.random((count, 2)).astype(np.float32)
    return Couplings(pairs, kept[0], acts, np.concatenate([push, kept[1], strength], axis=1))
