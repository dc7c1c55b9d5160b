"""Hair that is not simulated and follows a simulated neighbour."""

import numpy as np
from scipy.spatial import KDTree

from hairpipe.data import Groom, Strands
from hairpipe.groom.shares import at_shares, shares_of


def guided(hair: Strands, guides: Groom, groom: Groom, turns: np.ndarray, roots: np.ndarray) -> Strands:
    """Return all strands of a groom, each as the guide with the nearest root is, and as far from it as at rest; pure.

    hair    of the guides
    turns   of every root of the groom since rest, (S, 3, 3)
    roots   where they are [m], (S, 3)

    At a share a of the length, with X for rest and r for the root:
        x(a) = r + (x_g(a) - r_g) + R ((X(a) - X(0)) - (X_g(a) - X_g(0)))
    so that a guide follows itself, and hair that is moved rigidly with the body is right.
    """
    firsts, guide_firsts = groom.offsets[:-1], guides.offsets[:-1]
    nearest = np.asarray(KDTree(guides.points[guide_firsts]).query(groom.points[firsts])[1])
    strand, share = shares_of(groom.offsets)
    guide, points = nearest[strand], hair.points.astype(float)
    at_rest = (groom.points - groom.points[firsts][strand]) - (
        at_shares(guides.points, guides.offsets, guide, share) - guides.points[guide_firsts][guide]
    )
    bent = at_shares(points, hair.offsets, guide, share) - points[hair.offsets[:-1]][guide]
    placed = roots[strand] + bent + np.einsum("pij,pj->pi", turns[strand], at_rest)
    speeds = at_shares(hair.velocities, hair.offsets, guide, share)
    return Strands(placed.astype(np.float32), speeds.astype(np.float32), groom.offsets, hair.diameter)
