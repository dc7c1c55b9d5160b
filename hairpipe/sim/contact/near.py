"""Pairs of segments within a distance of each other."""

import numpy as np

from hairpipe.sim.contact.pairs import Pairs, key_of, measure


def candidates(points: np.ndarray, offsets: np.ndarray, radius: float) -> np.ndarray:
    """List pairs of segments, of any distance up to radius [m] and some beyond, (n, 2) int32, in order."""
    from scipy.spatial import KDTree

    if not np.isfinite(points).all():
        raise ArithmeticError("positions are not finite")
    segments = np.setdiff1d(np.arange(len(points)), np.asarray(offsets)[1:] - 1).astype(np.int32)
    if len(segments) < 2:
        return np.empty((0, 2), np.int32)
    ends = points[segments], points[segments + 1]
    length = np.linalg.norm(ends[1] - ends[0], axis=1).max()
    found = KDTree(0.5 * (ends[0] + ends[1])).query_pairs(1.000001 * (radius + length), output_type="ndarray")
    pairs = segments[np.sort(found, axis=1)]
    pairs = pairs[pairs[:, 1] - pairs[:, 0] > 1]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def near_pairs(points: np.ndarray, offsets: np.ndarray, reach: float, ignored: np.ndarray | None = None) -> Pairs:
    """List every pair of segments, of one strand too, that share no point and are within reach [m]; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64

    Raises ArithmeticError where a position is not finite.
    """
    pairs = measure(points, candidates(points, offsets, reach))
    keep = pairs.distances <= reach
    if ignored is not None:
        keep &= ~np.isin(key_of(pairs.segments), ignored)
    return Pairs(*(field[keep] for field in pairs))
