"""Clumps: tips of interpolated hair that taper towards the key beside it.

    y(a) = x(a) + p s((a - b) / (1 - b)) (x_g(a) - x(a)),   s(t) = t^2 (3 - 2 t)

at a share a of the length, from the share b on, with x_g the nearest of the keys that it follows and p the pull; its
lengths are kept, see `lengths_kept`. Velocities are the derivative.
"""

import numpy as np
from numba import njit, prange

from hairpipe.data import Strands
from hairpipe.groom.keys.key_weights import KeyWeights
from hairpipe.groom.keys.lengths_kept import drawn_to, speed_of_drawn
from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import length, minus, mix, row


def clumped(hair: Strands, keys: Strands, followed: KeyWeights, pull: float, begin: float) -> Strands:
    """Return hair whose tips have come nearer to the keys that it follows; pure.

    pull   share of the way to the key that the tip goes
    begin  share of the length before which nothing is pulled, less than 1
    """
    points, velocities = hair.points.copy(), hair.velocities.copy()
    _clump(followed, (keys.points, keys.velocities, keys.offsets), hair.offsets, (pull, begin), points, velocities)
    return Strands(points, velocities, hair.offsets, hair.diameter)


@njit(cache=True, parallel=True, error_model="numpy")
def _clump(
    followed: KeyWeights,
    keys: tuple[np.ndarray, np.ndarray, np.ndarray],
    offsets: np.ndarray,
    how: tuple[float, float],
    points: np.ndarray,
    velocities: np.ndarray,
) -> None:
    """Draw points to the keys, in place."""
    places, speeds, firsts = keys
    pull, begin = how
    for s in prange(len(offsets) - 1):
        if followed.own[s] >= 0:
            continue
        g, first, segments = followed.keys[s, 0], offsets[s], offsets[s + 1] - offsets[s] - 1
        theirs = firsts[g + 1] - firsts[g] - 1
        before = row(points, first)  # of the point before, as it was
        for k in range(1, segments + 1):
            i = first + k
            x, v = row(points, i), row(velocities, i)
            l, before = length(minus(x, before)), x
            share = min(max((k / segments - begin) / (1.0 - begin), 0.0), 1.0)
            near = pull * share * share * (3.0 - 2.0 * share)
            below = min(k * theirs // segments, theirs - 1)
            rest = k * theirs / segments - below
            a = firsts[g] + below
            y = mix(x, mix(row(places, a), row(places, a + 1), rest), near)
            speed = mix(v, mix(row(speeds, a), row(speeds, a + 1), rest), near)
            root, rate = row(points, i - 1), row(velocities, i - 1)
            put(points, i, drawn_to(root, y, l))
            put(velocities, i, speed_of_drawn(root, rate, y, speed, l))
