"""The closest few segments of every segment."""

import numpy as np

from hairpipe.sim.contact.near import near_pairs
from hairpipe.sim.contact.pairs import Pairs


def closest_pairs(
    points: np.ndarray,
    offsets: np.ndarray,
    reach: float,
    most: int,
    ignored: np.ndarray | None = None,
    room: np.ndarray | None = None,
) -> Pairs:
    """List pairs of segments within reach [m] that are among each other's closest; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    most     so many closest of each segment count; of equally close ones those with the lower number
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64
    room     a segment's own limit below `most`; one with 0 is passed over as if it were not there, (P,)

    No segment is in more pairs than its limit. Raises ArithmeticError where a position is not finite.
    """
    pairs = near_pairs(points, offsets, reach, ignored)
    limit = np.full(len(points), most) if room is None else np.minimum(room, most)
    keep = (limit[pairs.segments] > 0).all(axis=1)
    pairs = Pairs(*(field[keep] for field in pairs))
    chosen = np.ones(len(pairs.distances), bool)
    for side in (0, 1):
        own, other = pairs.segments[:, side], pairs.segments[:, 1 - side]
        of, others = np.concatenate([own, other]), np.concatenate([other, own])
        order = np.lexsort((others, np.tile(pairs.distances, 2), of))
        rank = np.empty(len(of), np.int64)
        rank[order] = np.arange(len(of)) - np.searchsorted(of[order], of[order])
        chosen &= (rank < limit[of])[: len(own)]
    return Pairs(*(field[chosen] for field in pairs))
