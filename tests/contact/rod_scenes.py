"""Rods of two points, thrown about, and the pairs that they make, found without the searches of the house."""

import numpy as np

from hairpipe.geometry.segments import Pairs


def closest(points, segments):
    """Fractions of the closest points and distances of pairs of segments: of the crossing and the four ends."""
    a, b = points[segments[:, 0]], points[segments[:, 1]]
    u, v = points[segments[:, 0] + 1] - a, points[segments[:, 1] + 1] - b

    def onto(p, q, d):
        return np.clip(((p - q) * d).sum(1) / (d * d).sum(1), 0.0, 1.0)

    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    r = b - a
    det = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (vv * (r * u).sum(1) - uv * (r * v).sum(1)) / det
        t = (uv * (r * u).sum(1) - uu * (r * v).sum(1)) / det
    crossing = (det > 1e-12 * uu * vv) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    zero, one = np.zeros(len(s)), np.ones(len(s))
    tries = [(np.where(crossing, s, 0.0), np.where(crossing, t, onto(a, b, v)))]
    tries += [(zero, onto(a, b, v)), (one, onto(a + u, b, v)), (onto(b, a, u), zero), (onto(b + v, a, u), one)]
    gaps = np.stack([np.linalg.norm(a + s[:, None] * u - b - t[:, None] * v, axis=1) for s, t in tries])
    best = gaps.argmin(0)
    rows = np.arange(len(best))
    fractions = np.stack([np.stack(both, 1) for both in tries])[best, rows]
    return fractions, gaps[best, rows]


def segments_of(rods):
    """The first points of so many rods."""
    return np.arange(0, 2 * rods, 2)


def pairs_within(points, segments, reach):
    """Every pair of segments that share no point and are nearer than reach."""
    segments = np.asarray(segments, np.int32)
    i, j = np.triu_indices(len(segments), 1)
    both = np.stack([segments[i], segments[j]], 1)
    both = both[both[:, 1] - both[:, 0] > 1]
    fractions, distances = closest(points, both)
    near = distances < reach
    order = np.lexsort((both[near, 1], both[near, 0]))
    return Pairs(both[near][order], fractions[near][order], distances[near][order])


def thrown(count, size, length, speed, seed):
    """Rods in a cube of a size [m], all with random directions and velocities of their points."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(0.0, size, (count, 3))
    direction = rng.normal(size=(count, 3))
    half = 0.5 * length * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    points = np.stack([middle - half, middle + half], 1).reshape(-1, 3)
    return points, speed * rng.normal(size=points.shape)


def jacobian(pairs, points):
    """J of all pairs, (3 pairs, 3 points)."""
    J = np.zeros((len(pairs.segments), 3, points, 3))
    rows = np.arange(len(pairs.segments))
    (a, b), (s, t) = pairs.segments.T, pairs.fractions.T
    for c in range(3):
        for place, weight in ((a, 1 - s), (a + 1, s), (b, t - 1), (b + 1, -t)):
            J[rows, c, place, c] += weight
    return J.reshape(-1, 3 * points)


def cross(height):
    """Two rods of 10 mm that cross in the middle, one at a height [m] over the other, and their one pair."""
    points = np.array([[-5e-3, height, 0.0], [5e-3, height, 0.0], [0.0, 0.0, -5e-3], [0.0, 0.0, 5e-3]])
    segments = np.array([[0, 2]], np.int32)
    return points, Pairs(segments, *closest(points, segments))
