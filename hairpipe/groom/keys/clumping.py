"""Clumps: tips of interpolated hair taper towards the nearest key.

    y(a) = x(a) + p s((a - b) / (1 - b)) (x_g(a) - x(a)),   s(t) = t^2 (3 - 2 t)

at a share a of the length, from the share b on, with x_g the nearest of the keys that it follows and p the pull.
Segments have the directions of those between the y, and their original lengths. Velocities are the exact derivative.
"""

from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.data import Strands
from hairpipe.groom.keys.interpolating import go_on
from hairpipe.groom.keys.key_weights import KeyWeights
from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import length, minus, mix, row


def clumped(hair: Strands, keys: Strands, followed: KeyWeights, pull: float, begin: float) -> Strands:
    """Return hair with its tips pulled towards the keys that it follows; pure.

    pull   share of the distance to the key by which the tip moves
    begin  share of the length at which the pull begins, less than 1
    """
    points = hair.points.copy()
    velocities = hair.velocities.copy()
    _clump(followed, (keys.points, keys.velocities, keys.offsets), hair.offsets, (pull, begin), points, velocities)
    return replace(hair, points=points, velocities=velocities)


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
        if followed.own[s] >= 0:  # A key is not drawn to itself.
            continue
        g = followed.keys[s, 0]
        first = offsets[s]
        segments = offsets[s + 1] - offsets[s] - 1
        theirs = firsts[g + 1] - firsts[g] - 1
        x, v = row(points, first), row(velocities, first)
        before, last, last_speed = x, x, v  # the point before, and where it was drawn to
        for k in range(1, segments + 1):
            i = first + k
            l = length(minus(row(points, i), before))
            before = row(points, i)
            share = min(max((k / segments - begin) / (1.0 - begin), 0.0), 1.0)
            near = pull * share * share * (3.0 - 2.0 * share)
            below = min(k * theirs // segments, theirs - 1)  # In whole numbers: equal counts meet point to point.
            rest = k * theirs / segments - below
            a = firsts[g] + below
            y = mix(before, mix(row(places, a), row(places, a + 1), rest), near)
            speed = mix(row(velocities, i), mix(row(speeds, a), row(speeds, a + 1), rest), near)
            x, v = go_on(x, v, l, minus(y, last), minus(speed, last_speed))
            last, last_speed = y, speed
            put(points, i, x)
            put(velocities, i, v)
