"""Tetrahedra of four particles in numpy: volumes, and the directions of their seven altitudes; Sec. 3.1.

The kernel of the springs has the same formulas, for lanes (`sim/strands/forces/altitude.py`).
"""

import numpy as np

SECONDS, THIRDS = [1, 1, 2], [2, 3, 3]
"""Faces whose area vectors add up to u x v of two opposite edges."""


def area_vectors(fours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of six times the volume, and that volume, which may have either sign.

    fours    [m], (..., 4, 3)
    returns  (..., 4, 3) [m^2], (...) [m^3]
    """
    a, b, c, d = np.moveaxis(fours, -2, 0)
    n1, n2, n3 = np.cross(c - a, d - a), np.cross(d - a, b - a), np.cross(b - a, c - a)
    return np.stack([np.negative(n1 + n2 + n3), n1, n2, n3], axis=-2), np.sum(n1 * (b - a), axis=-1)


def altitude_vectors(areas: np.ndarray) -> np.ndarray:
    """Add u x v of opposite edges to area vectors, (..., 4, 3): (..., 7, 3) [m^2], as `altitude.py` has them."""
    return np.concatenate([areas, areas[..., SECONDS, :] + areas[..., THIRDS, :]], axis=-2)
