"""Hair that is not simulated and follows a simulated neighbour."""

import numpy as np
from scipy.spatial import KDTree

from hairpipe.data import Groom, Strands
from hairpipe.groom.strand_arrays import at_shares, shares_of


def guided(hair: Strands, guides: Groom, groom: Groom, motions: np.ndarray, rates: np.ndarray) -> Strands:
    """Return all strands of a groom, each as its guide is, and as far from it as at rest; pure.

    The guide is that with the nearest root; among those that share a root, that of the same id.

    hair            of the guides
    motions, rates  of every root of the groom from where that put it, x -> R x + t, and their derivative by time, as
                    `motion_of_roots` gives them, (S, 3, 4)

    At a share a of the length, with X for rest, x_g and X_g for the guide:
        x(a) = R (X(a) - (X_g(a) - X_g(0))) + t + (x_g(a) - x_g(0))
    so that a guide follows itself, and hair that is moved rigidly with the body is right. Velocities are the derivative
    of that.
    """
    nearest = guides_of(groom, guides)
    strand, share = shares_of(groom.offsets)

    def along(values: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Values of the guides less those of their roots, at the points of the groom."""
        guide = nearest[strand]
        return at_shares(values.astype(float), offsets, guide, share) - values[offsets[:-1]][guide]

    carried = groom.points - along(guides.points, guides.offsets)
    placed = _moved(motions[strand], carried) + along(hair.points, hair.offsets)
    speeds = _moved(rates[strand], carried) + along(hair.velocities, hair.offsets)
    return Strands(placed, speeds.astype(np.float32), groom.offsets, hair.diameter)


def guides_of(groom: Groom, guides: Groom) -> np.ndarray:
    """Return which guide every strand of a groom has, (S,)."""
    roots, theirs = (some.points[some.offsets[:-1]] for some in (groom, guides))
    found = np.asarray(KDTree(theirs).query(roots)[1])
    _, strands, same = np.intersect1d(groom.ids, guides.ids, return_indices=True)
    here = (roots[strands] == theirs[same]).all(axis=1)  # ids of guides that were grown apart say nothing
    found[strands[here]] = same[here]
    return found


def _moved(motions: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return R x + t, (n, 3), for motions (n, 3, 4)."""
    return np.einsum("pij,pj->pi", motions[:, :, :3], points) + motions[:, :, 3]
