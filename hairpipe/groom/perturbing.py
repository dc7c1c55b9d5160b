"""Members of an ensemble of grooms, which differ imperceptibly: they separate chaos from bias."""

from dataclasses import replace

import numpy as np

from hairpipe.data import Groom
from hairpipe.errors import BadInput
from hairpipe.groom.binding import name_strands
from hairpipe.groom.random_streams import stream
from hairpipe.groom.strand_arrays import shares_of


def perturbed(groom: Groom, member: int, tip: float) -> Groom:
    """Return a member of the ensemble around a groom: every strand is rotated rigidly about its root; pure.

    member  0 is the groom itself
    tip     standard deviation of each component of the tip's target [m]: the distance of root and tip is unchanged, so
            that the tip moves by this in both directions normal to the line between them

    The rotation of a strand depends only on its id and the member, not on the other strands. Raises BadInput for held
    tips.
    """
    if member == 0:
        return groom
    if groom.tip_triangles is not None and (groom.tip_triangles >= 0).any():
        held = name_strands(groom.ids[groom.tip_triangles >= 0])
        raise BadInput(f"the tip is held of {held}", where="groom", right="strands held at the root alone")
    roots = groom.points[groom.offsets[:-1]]
    lines = groom.points[groom.offsets[1:] - 1] - roots
    aims = lines + [tip * stream(member, f"perturb/{strand}").standard_normal(3) for strand in groom.ids]
    here, there = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (lines, aims))
    axes = np.cross(here, there)
    cosines = np.sum(here * there, axis=1)
    strands, _ = shares_of(groom.offsets)
    axes = axes[strands]
    cosines = cosines[strands, None]
    arms = groom.points - roots[strands]
    # Rodrigues, with the sine in the axis: the turn of v is v + a x v + a x (a x v) / (1 + cos).
    across = np.cross(axes, arms)
    return replace(groom, points=groom.points + (across + np.cross(axes, across) / (1.0 + cosines)))
