"""Normals of the hair shell, transported by the hair.

    N_k(now) = Q_k grad S(x_k at rest)

with Q_k the rotation of the segment after point k since rest, see `key_turns`: Petrovic, Henne, Anderson 2005,
Sec. 4.1, who use frames of Bishop 1975 that are fixed to the head at the root.
"""

import numpy as np

from hairpipe.data import Groom, LevelSet, Normals, Strands
from hairpipe.errors import BadInput
from hairpipe.groom.keys.key_turns import turns_since
from hairpipe.levelset.collider import SdfSample
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.interpolation import Interpolation


def probe_shell(points: np.ndarray, shell: LevelSet) -> SdfSample:
    """Return the signed distance and its unit gradient at points [m], (P, 3); inf and 0 beyond its band."""
    found = SdfSample.blank(len(points))
    build_collider_field(shell, shell, 1.0, Interpolation.linear).probe(points, 0.0, found)
    return found


def rotated_normals(rest: np.ndarray, groom: Groom, hair: Strands, roots: tuple[np.ndarray, np.ndarray]) -> Normals:
    """Return unit normals rotated with the hair since rest; pure.

    rest   normals at the points of the groom, (P, 3)
    roots  rigid motions of the roots of the groom, x -> R x + t, and their time derivatives, (S, 3, 4) float64

    Raises BadInput if hair and groom are not the same strands.
    """
    if not np.array_equal(hair.offsets, groom.offsets):
        raise BadInput("hair and groom are not the same strands", right="in.groom: the groom that is simulated")
    turns = turns_since(groom.points, hair, *roots).turns
    tips = groom.offsets[1:] - 1
    turns[tips] = turns[tips - 1]
    return Normals(np.einsum("pij,pj->pi", turns, rest).astype(np.float32))
