"""Pinching: points inside bodies for which there is no free place outside."""

from collections.abc import Sequence

import numpy as np

from hairpipe.levelset.collider import Collider, SdfSample

ROOM = 1e-3
"""Distance from the body of a free position: the default thickness of hair [m]."""
_STEPS = 12
_ENOUGH = 0.5  # of the clearance; distances are not exact
_FARTHEST = 2.0  # length of the traced path, over the sum of depth and clearance


def is_pinched(points: np.ndarray, depths: np.ndarray, bodies: Sequence[Collider]) -> np.ndarray:
    """Return the points inside bodies without free space, as where two bodies overlap, (P,); pure.

    points  [m], (P, 3); depths  depths inside the bodies [m], (P,)
    bodies  at time zero

    A path out is traced along the normals, out of every body that it enters, up to twice the sum of depth and
    clearance: a point is pinched if there is no free position on it. It is not pinched if the path ends at an
    undefined normal.
    """
    places = points.copy()
    pinched = np.ones(len(points), bool)
    reach = _FARTHEST * (depths + ROOM)
    for _ in range(_STEPS):
        probe = SdfSample.blank(len(points), 2.0 * ROOM)
        for body in bodies:
            body.probe(places, 0.0, probe)
        near = np.linalg.norm(places - points, axis=1) <= reach
        outside = (probe.distance > _ENOUGH * ROOM) & near
        lost = (probe.distance < 0.0) & ~probe.normal.any(axis=1)
        pinched &= ~(outside | lost)
        places += np.maximum(ROOM - probe.distance, 0.0)[:, None] * probe.normal
    return pinched
