"""Hair where bodies leave less room than it wants stays between them, and is not thrown from one to the other.

A point at the distance phi < kept along the normal n would be moved out to x + (kept - phi) n. Where a body stands
against it there, with a normal m.n < 0, nearer than the thickness d, at b, the room is kept + b and not kept + d, and
the point keeps its share of that:

    kept (kept + b) / (kept + d)

which is the middle where kept = d. Bodies that overlap have b < -kept: the point is then equally deep in both.
"""

from collections.abc import Sequence

import numpy as np

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
) -> np.ndarray:
    """Return what points keep from bodies [m], (P,), where these leave less room than kept; pure.

    points     [m], (P, 3), at a time since the previous frame [s]
    probe      of the bodies there
    thickness  that points want on all sides [m], (P,)
    kept       from the body that is nearest, at least that [m], (P,)
    """
    pushed = np.flatnonzero(probe.distance < kept - _PUSHED)
    pushed = pushed[probe.normal[pushed].any(axis=1)]
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
    share = target_gap / np.maximum(target_gap + thickness[pushed], _PUSHED)
    out[pushed[against]] = (share * room)[against]
    return out
