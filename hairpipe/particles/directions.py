"""Directions of the hair at particles, (15) of Bando, Chen, Nishita 2003.

Every link predicts the direction of the hair at its end i: its own direction d, rotated by the angle theta at rest, in
the plane of d and the present direction of the hair,

    t_i <- unit of sum K (cos theta d + sin theta p / max(|p|, 1e-3)),   p = t_i - (t_i . d) d

We differ from the paper if t_i is parallel to d, so that the plane is undefined, and for particles without links:
there the hair keeps its direction.
"""

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import flattened, length, row
from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.model import Links

LEAST = 1e-3
"""Sine of the angle with a link below which a direction is not turned by it whole."""


@njit(cache=True, error_model="numpy")
def turn_directions(links: Links, ways: np.ndarray, stiffness: np.ndarray, deep: int, directions: np.ndarray) -> None:
    """Turn the directions of free particles, in place; those below the skin turn with their roots.

    ways       vectors of the links, as `measure_links` writes them, (E, 4)
    stiffness  stiffness of the links [N/m], (E,)
    """
    sums = np.zeros_like(directions)
    for e in range(len(links.ends)):
        d = row(ways, e)
        _add(links.ends[e, 0], links.cosines[e, 0], d, stiffness[e], directions, sums)
        _add(links.ends[e, 1], links.cosines[e, 1], d, stiffness[e], directions, sums)
    for k in range(deep, len(directions)):
        size = length(row(sums, k))
        if size > 0.0:
            for c in range(3):
                directions[k, c] = sums[k, c] / size


@njit(cache=True, error_model="numpy")
def redirect(
    links: Links,
    reach: float,
    axial: np.ndarray,
    deep: int,
    points: np.ndarray,
    stiffness: np.ndarray,
    directions: np.ndarray,
) -> None:
    """Turn directions, and write the stiffness of links [N/m], (E,), at points [m], (N, 3), in place.

    reach, axial  as `stiffen` takes them
    """
    ways = np.empty((len(links.ends), 4))
    measure_links(links, points, ways)
    stiffen(links, reach, axial, ways, stiffness)
    turn_directions(links, ways, stiffness, deep, directions)


@inlined
def _add(k, cosine, d, stiffness, directions, sums):
    """Add where a link leads the hair of particle k, in place."""
    p = flattened(row(directions, k), d)
    along = stiffness * cosine
    # Nearly along d the plane is arbitrary: the turn fades out instead of jumping.
    across = stiffness * np.sqrt(max(1.0 - cosine * cosine, 0.0)) / max(length(p), LEAST)
    for c in range(3):
        sums[k, c] += along * d[c] + across * p[c]
