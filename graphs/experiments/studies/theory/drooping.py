"""Rod theory of straight strands at rest under their own weight."""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.theory.elastica import Elastica, bend_elastica
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import shares_of

_STRAIGHT, _UPRIGHT = 1e-6, 0.999


def drooped(groom: Groom, material: Material, gravity: float) -> Strands:
    """Return straight strands bent as the heavy elastica, each in its vertical plane, clamped as the groom has it.

    gravity  along -Y [m/s^2]
    Raise BadInput where a strand is not straight, or upright, where the elastica has no plane.
    """
    strands, shares = shares_of(groom.offsets)
    points = np.empty((len(strands), 3))
    known: dict[tuple[float, float], Elastica] = {}
    for strand in range(len(groom.ids)):
        mine = slice(*groom.offsets[strand : strand + 2])
        root = groom.points[mine][0]
        along = groom.points[mine][-1] - groom.points[mine][0]
        length = float(np.linalg.norm(along))
        straight = root + np.outer(shares[mine], along)
        rise = float(along[1]) / length
        if np.abs(groom.points[mine] - straight).max() > _STRAIGHT * length or abs(rise) > _UPRIGHT:
            raise BadInput(f"strand {groom.ids[strand]} is bent or upright", right="straight strands that point aside")
        level = along * (1.0, 0.0, 1.0)
        gamma = material.line_density * gravity * length**3 / material.bending
        case = round(gamma, 9), round(rise, 9)
        if case not in known:
            known[case] = bend_elastica(gamma, float(np.arcsin(rise)))
        bent = known[case]
        out, up = (length * np.interp(shares[mine], bent.arc, bent.points[:, axis]) for axis in (0, 1))
        points[mine] = root + np.outer(out, level / np.linalg.norm(level)) + np.outer(up, (0.0, 1.0, 0.0))
    return Strands(points, np.zeros_like(points, np.float32), groom.offsets, material.diameter)
