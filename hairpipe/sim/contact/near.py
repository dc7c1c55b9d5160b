"""Pairs of segments within a distance of each other."""

import numpy as np

from hairpipe.sim.contact.found import in_order
from hairpipe.sim.contact.pairs import Pairs, chosen, known_pairs, measure
from hairpipe.sim.contact.search import search
from hairpipe.sim.contact.segments import all_segments, refuse_lost
from hairpipe.sim.contact.tree import build_tree, find_frame


def near_pairs(points: np.ndarray, offsets: np.ndarray, reach: float, ignored: np.ndarray | None = None) -> Pairs:
    """List every pair of segments, of one strand too, that share no point and are within reach [m]; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64

    Raises ArithmeticError where a position is not finite.
    """
    refuse_lost(points)
    return near_pairs_of(points, all_segments(len(points), offsets), reach, ignored)


def near_pairs_of(points: np.ndarray, segments: np.ndarray, reach: float, ignored: np.ndarray | None) -> Pairs:
    """List the pairs of which both are among some segments, (m,) int32; otherwise as `near_pairs`."""
    tree = build_tree(points, None, segments, reach, find_frame(points, points, segments))
    found = search(tree, tree, known_pairs(ignored, len(points)))
    pairs = measure(points, in_order(found, len(points)))
    return chosen(pairs, pairs.distances <= reach)
