"""Pairs of segments that pass through each other in a step, with place and time: Sec. 5.3, edge against edge."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compaction import places_of
from hairpipe.kernels.simd import WIDTH, lowest
from hairpipe.sim.contact.ccd.coplanarity import ROWS, coplanar_time, may_cross
from hairpipe.sim.contact.ccd.moving_segments import crossing_normal, encounter, meet
from hairpipe.spatial.pairs import key_of

_CHUNK = 1024


class Crossings(NamedTuple):
    """The first crossing of each pair of crossing segments.

    segments   first < second, rows in lexicographic order, (n, 2) int32
    fractions  positions of the crossing on both segments, (n, 2) float64
    times      time of the crossing, a fraction of the step, (n,) float64
    normals    normal to both, from the second to the first before the crossing, (n, 3) float64
    """

    segments: np.ndarray
    fractions: np.ndarray
    times: np.ndarray
    normals: np.ndarray


def crossings(before: np.ndarray, after: np.ndarray, pairs: np.ndarray) -> Crossings:
    """Find the pairs of segments that pass through or touch each other in a linear motion; pure.

    before, after  positions [m], (P, 3) float64
    pairs          candidates, see `swept_pairs`, (n, 2) int32

    Bridson et al. 2002, edges alone: segments that meet at an end point are left out, unless an edge passes exactly
    through a joint.
    """
    times = np.empty(len(pairs))
    meet = np.empty(len(pairs), np.bool_)
    _find_times(before, after, pairs, times, meet)
    found = places_of(meet)
    found = found[np.argsort(key_of(pairs[found]), kind="stable")]
    times, segments = times[found], pairs[found]
    fractions, normals = np.empty((len(found), 2)), np.empty((len(found), 3))
    _describe(before, after, segments, times, fractions, normals)
    return Crossings(segments, fractions, times, normals)


@njit(cache=True, parallel=True)
def _find_times(before, after, pairs, times, meet):
    """Mark the pairs that meet, and write when, in place."""
    for chunk in prange(-(-len(pairs) // _CHUNK)):
        room = np.empty((ROWS, WIDTH))
        for start in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(pairs)), WIDTH):
            meet[start : start + WIDTH] = False
            # Signs of eight cubics at once; most pairs end here, and the rest are solved one by one.
            possible = may_cross(before, after, pairs, start, room)
            while possible != 0:
                k = start + lowest(possible)
                possible &= possible - 1
                times[k] = coplanar_time(encounter(before, after, pairs[k, 0], pairs[k, 1]))
                meet[k] = times[k] <= 1.0


@njit(cache=True, parallel=True)
def _describe(before, after, segments, times, fractions, normals):
    for k in prange(len(segments)):
        pair = encounter(before, after, segments[k, 0], segments[k, 1])
        fractions[k, 0], fractions[k, 1], _ = meet(pair, times[k])
        normal = crossing_normal(pair, times[k], fractions[k, 0], fractions[k, 1])
        normals[k, 0], normals[k, 1], normals[k, 2] = normal
