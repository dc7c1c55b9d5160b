"""Density of roots on the body: skin between drawn strands has the colour of hair."""

import numpy as np
from numba import njit

from hairpipe.render.shadows import CELLS, add, look_up_all

REACH = 0.012
"""Edge of the cells in which roots are counted: the softness of the hairline [m]."""
NEIGHBOURS = 4


def hair_share(points: np.ndarray, roots: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the density of roots on the skin over the usual one, at most 1, (n,) float64.

    Few strands do not cover the skin: in cells of REACH each root would be a spot. Cells grow with the distance of
    roots, and the share falls with their area.

    points  of the skin [m], (n, 3) float64
    roots   [m], (S, 3) float64
    axes    of the cells, rows of a rotation, (3, 3)
    """
    edge = max(REACH, spacing(roots))
    shift = CELLS / 2 - axes @ roots.mean(axis=0) / edge
    to_cells = np.column_stack([axes / edge, shift])
    counts = np.zeros((CELLS, CELLS, CELLS), np.float32)
    count(counts, roots @ to_cells[:, :3].T + shift)
    usual = np.median(look_up_all(counts, to_cells, roots))
    return (REACH / edge) ** 2 * np.clip(look_up_all(counts, to_cells, points) / max(usual, 1e-6), 0.0, 1.0)


def spacing(roots: np.ndarray) -> float:
    """Return the edge of the square of skin per root [m]; infinity for a single root; roots (S, 3).

    The disc around a root that reaches its k-th neighbour has the area of k such squares.
    """
    from scipy.spatial import KDTree  # here: a node that names this function is read without it

    distances, _ = KDTree(roots).query(roots, 1 + NEIGHBOURS)
    known = np.isfinite(distances).sum(axis=1) - 1
    farthest = distances[np.arange(len(roots)), known]
    return float(np.median(farthest * np.sqrt(np.pi / known))) if len(roots) > 1 else np.inf


@njit(cache=True, nogil=True)
def count(counts: np.ndarray, places: np.ndarray) -> None:
    """Count the places (n, 3) in the cells, in place."""
    for p in range(len(places)):
        add(counts, places[p, 0], places[p, 1], places[p, 2], 1.0)
