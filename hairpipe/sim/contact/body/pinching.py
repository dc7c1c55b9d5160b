"""Hair in a narrow gap between bodies stays there, and does not jump from one body to the other.

A point at the distance phi < kept along the normal n would be moved out to x + (kept - phi) n. If a body opposes it
there, with a normal m.n < 0, at a distance b below the thickness d, the gap is kept + b instead of kept + d, and the
point takes its share of the gap:

    kept (kept + b) / (kept + d)

which is the middle where kept = d. Bodies that overlap have b < -kept: the point is then equally deep in both.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compaction import places_of
from hairpipe.levelset.collider import Collider, SdfSample

_PUSHED = 1e-4  # [m]; points that are moved out by less are not looked at
_AGAINST = -0.5  # cosine between normals


def share_gap(
    points: np.ndarray,
    time: float,
    surfaces: Sequence[Collider],
    probe: SdfSample,
    thickness: np.ndarray,
    kept: np.ndarray,
    scale: float = 1.0,
) -> np.ndarray:
    """Return the contact distances of points [m], (P,), reduced in narrow gaps between bodies; pure.

    points     [m], (P, 3), at a time since the previous frame [s]
    probe      probe of the bodies at the points
    thickness  desired distance on all sides [m], (P,)
    kept       contact distance from the nearest body, at least the thickness [m], (P,)
    scale      of lengths [1], see `Scale`
    """
    is_pushed = np.empty(len(points), np.bool_)
    _mark_pushed(probe, kept, scale * _PUSHED, is_pushed)
    pushed = places_of(is_pushed)
    if not len(pushed):
        return kept
    target_gap = kept[pushed]
    normals = probe.normal[pushed]
    ahead = SdfSample.blank(len(pushed), float(thickness.max(initial=0.0)))
    for surface in surfaces:
        surface.probe(points[pushed] + (target_gap - probe.distance[pushed])[:, None] * normals, time, ahead)
    against = np.einsum("pc,pc->p", ahead.normal, normals) < _AGAINST
    room = target_gap + np.minimum(ahead.distance, thickness[pushed])
    out = kept.copy()
    share = target_gap / np.maximum(target_gap + thickness[pushed], scale * _PUSHED)
    out[pushed[against]] = (share * room)[against]
    return out


@njit(cache=True, parallel=True)
def _mark_pushed(probe, kept, least, marked):
    """Mark points that are moved out along a normal by more than the least [m], (P,) bool, in place."""
    for i in prange(len(kept)):
        n = probe.normal[i]
        marked[i] = probe.distance[i] < kept[i] - least and (n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0)
