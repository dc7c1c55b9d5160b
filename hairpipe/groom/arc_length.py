"""Places along strands as shares of their length, the same however strands are cut into segments."""

import numpy as np


def at_shares(values: np.ndarray, offsets: np.ndarray, strands: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return values of points, (P, 3), at shares 0..1 of the length of strands, linear between points, (n, 3); pure.

    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    strands  whose share each is, (n,)
    """
    segments = (np.diff(offsets) - 1)[strands]
    place = shares * segments
    below = np.minimum(place.astype(int), segments - 1)
    rest, begin = (place - below)[:, None], offsets[strands] + below
    return (1.0 - rest) * values[begin] + rest * values[begin + 1]


def shares_of(offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return whose every point is, and at which share of its length, (P,) each."""
    segments = np.diff(offsets) - 1
    strands = np.repeat(np.arange(len(segments)), segments + 1)
    return strands, (np.arange(len(strands)) - offsets[strands]) / segments[strands]
