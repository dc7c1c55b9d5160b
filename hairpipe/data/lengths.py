"""Lengths of strands and their segments."""

import numpy as np


def segment_lengths(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the lengths of all segments [m], strand after strand, (P - S,) float64.

    points   root first, strand after strand [m], (P, 3)
    offsets  strand s owns points offsets[s]:offsets[s+1], (S + 1,)
    """
    return np.delete(_ways(points), offsets[1:-1] - 1)


def strand_lengths(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the length of every strand along its segments [m], (S,) float64; arguments as in `segment_lengths`."""
    ways = _ways(points)
    ways[offsets[1:-1] - 1] = 0.0
    return np.add.reduceat(ways, offsets[:-1])


def fractions_along(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return how far every point is along its strand, 0 at the root and 1 at the tip, (P,) float64; pure.

    Arguments as in `segment_lengths`; no strand is without length.
    """
    ways = np.concatenate([[0.0], _ways(points)])
    ways[offsets[:-1]] = 0.0
    along = np.cumsum(ways)
    counts = np.diff(offsets)
    roots = along[offsets[:-1]]
    lengths = along[offsets[1:] - 1] - roots
    return (along - np.repeat(roots, counts)) / np.repeat(lengths, counts)


def unequal(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the difference of the longest and the shortest segment of every strand [m], (S,) float64."""
    lengths = segment_lengths(points, offsets)
    starts = offsets[:-1] - np.arange(len(offsets) - 1)
    return np.maximum.reduceat(lengths, starts) - np.minimum.reduceat(lengths, starts)


def _ways(points: np.ndarray) -> np.ndarray:
    """Return the distances from each point to the next [m], those from tips to roots among them."""
    return np.linalg.norm(np.diff(points.astype(float), axis=0), axis=1)
