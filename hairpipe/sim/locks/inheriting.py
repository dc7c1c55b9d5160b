"""Connections of new followers are moved to their guides."""

import numpy as np
from numba import njit

from hairpipe.sim.contact.hair.stiction import Connections
from hairpipe.spatial.pairs import key_of


def inherited(
    connections: Connections, ages: np.ndarray, leaders: np.ndarray, offsets: np.ndarray, closest: int
) -> tuple[Connections, np.ndarray]:
    """Return the connections of guides, in order, and their ages in frames, (m,) int32; pure.

    connections  connections of strands simulated so far; ages  their ages in frames, (n,) int32
    leaders      new guide of every strand, (S,) int32; offsets  offsets of the strands, (S+1,) int32
    closest      maximum number of connections of a segment: a guide's own take precedence, then the oldest

    A connection moves to the same segment of the guide, which has as many segments; connections of a guide to itself
    are deleted.
    """
    strands = np.searchsorted(offsets, connections.segments, side="right") - 1
    theirs = leaders[strands]
    segments = connections.segments + (offsets[theirs] - offsets[strands])
    swapped = segments[:, 0] > segments[:, 1]
    segments = np.where(swapped[:, None], segments[:, ::-1], segments).astype(np.int32)
    fractions = np.where(swapped[:, None], connections.fractions[:, ::-1], connections.fractions)
    own = (theirs == strands).all(axis=1)
    apart = own | (theirs[:, 0] != theirs[:, 1])
    order = np.lexsort((-ages, ~own))
    order = order[apart[order]]
    _, firsts = np.unique(key_of(segments[order]), return_index=True)
    order = order[np.sort(firsts)]
    kept = order[_with_room(segments[order], np.zeros(offsets[-1], np.int64), closest)]
    kept = kept[np.argsort(key_of(segments[kept]), kind="stable")]
    return Connections(segments[kept], fractions[kept]), ages[kept]


@njit(cache=True)
def _with_room(segments, taken, most):
    """Mark the pairs, one after the other, for which both segments have room, (n,) bool."""
    kept = np.empty(len(segments), np.bool_)
    for k in range(len(segments)):
        a, b = segments[k]
        kept[k] = taken[a] < most and taken[b] < most  # In the order of priority: those that come first take the room.
        taken[a] += kept[k]
        taken[b] += kept[k]
    return kept
