"""Biased strain limiting: Sec. 4.2 of Selle, Lentine, Fedkiw 2008.

From root to tip every particle that lies farther than (1 + tolerance) l0 from its neighbour nearer the root is moved
along the line between them, and only it moves, so that one pass satisfies every limit. A perturbed particle depends on
the one of its two edges that is nearer the root.

We differ from the paper: the limit is a tolerance, not the rest length, so that springs balance the weight of hair at
rest and no hidden velocity grows, and the velocity is not corrected, which would add energy. Hair so soft that its
weight stretches it by more than the tolerance is held by the limit only, and its velocity grows: it needs a greater
tolerance. Real hair stretches by 1e-6, and by 1e-4 with the default softening.

Only the far particle moves, so momentum is not kept. A default hair of 30 cm in a shake of 2,500 deg/s is within the
tolerance; one six times as soft loses a hundredth of what the weight gives, at most (tests/shot/test_strain.py).
"""

import numpy as np
from numba import njit

from hairpipe.geometry.simd import load, maximum, select, sqrt, store
from hairpipe.geometry.vec3 import dot, minus


@njit(cache=True)
def _draw_in(x, p, parent, inverse_rest, limit):
    """Move particle p towards its parent until their distance is at most limit times the rest length, or not at all."""
    here = load(x, (p, 0)), load(x, (p, 1)), load(x, (p, 2))
    near = load(x, (parent, 0)), load(x, (parent, 1)), load(x, (parent, 2))
    way = minus(here, near)
    stretch = sqrt(dot(way, way)) * inverse_rest
    scale = limit / maximum(stretch, 1e-12)
    for c in range(3):  # What is within the limit keeps its bits: p + (x - p) may differ from x by rounding.
        store(x, (p, c), select(stretch > limit, near[c] + scale * way[c], here[c]))


@njit(cache=True)
def limit_strain(x: np.ndarray, inverse_lengths: np.ndarray, shape, limit: float) -> None:
    """Shorten every segment of a block of strands that is stretched beyond the limit, in place.

    x                positions [m], (particles, 3, W)
    inverse_lengths  of the springs, see the model, (particles, springs, W)
    shape            `Shape` of the strands in `strands/layout.py`
    limit            length over that at rest, of all strands or lanes with that of each
    """
    for p in range(shape.clamped, x.shape[0] - shape.after):  # From the root on, so that one pass is enough.
        parent = p - 1 if p % shape.stride else p - shape.stride
        _draw_in(x, p, parent, load(inverse_lengths, (parent, p - parent - 1)), limit)
