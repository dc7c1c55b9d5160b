"""Pairs of segments that may come near each other within a step."""

import numpy as np

from hairpipe.sim.contact.near import candidates
from hairpipe.sim.contact.pairs import key_of, measure


def swept_pairs(
    before: np.ndarray, after: np.ndarray, offsets: np.ndarray, reach: float, ignored: np.ndarray | None = None
) -> np.ndarray:
    """List all pairs of segments that get within reach [m] in a linear motion, and some others, (n, 2) int32; pure.

    before, after  positions [m], (P, 3) float64
    offsets        strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    ignored        sorted keys of pairs to leave out, see `key_of`, (k,) int64

    In order, first < second; the two share no point. Two segments get nearer than at half time, d, by no more than
    half the largest relative displacement D of their ends: kept are pairs with d <= reach + D / 2.
    Raises ArithmeticError where a position is not finite.
    """
    middle, half = 0.5 * (before + after), 0.5 * (after - before)
    half = half - half.mean(axis=0)
    segments = candidates(middle, offsets, reach + 2.0 * np.linalg.norm(half, axis=1).max(initial=0.0))
    first, second = segments[:, 0], segments[:, 1]
    moved = [np.linalg.norm(half[first + a] - half[second + b], axis=1) for a in (0, 1) for b in (0, 1)]
    keep = measure(middle, segments).distances <= 1.000001 * (reach + np.max(moved, axis=0))
    if ignored is not None:
        keep &= ~np.isin(key_of(segments), ignored)
    return segments[keep]
