"""A natural curvature for every strand, of random direction: the waviness of hair that nobody has styled.

Every segment turns from the one before it as in the groom, and by l / R more, l the mean length of both and R the curl
radius of the strand, about a direction that is fixed in the material: a straight strand becomes an arc. Radii are
log-normal, so that all are positive.

Source: Nagase et al., Characterization of curved hair of Japanese women, J. Cosmet. Sci. 59, 317, 2008: mean and
standard deviation of the curl radius of 2,300 hairs.
"""

from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.geometry.vec3 import Vector, cross, dot, length, minus, plus, put, row, scaled, unit
from hairpipe.values import Groom
from hairpipe.values.random_streams import chances

_LEAST = 1e-12


def radii_of(ids: np.ndarray, mean: float, spread: float, seed: int) -> np.ndarray:
    """Return log-normal curl radii of strands [m], (n,), of a mean and a standard deviation [m]."""
    share = np.maximum((chances(seed, "curl radius", ids) + 1.0) / 2.0, _LEAST)
    normal = np.sqrt(-2.0 * np.log(share)) * np.cos(np.pi * chances(seed, "curl radius, angle", ids))  # Box and Muller
    variance = np.log1p((spread / mean) ** 2)
    return mean * np.exp(np.sqrt(variance) * normal - variance / 2.0)


def curved(groom: Groom, mean: float, spread: float, seed: int) -> Groom:
    """Return a groom whose strands have a further curvature; pure. Roots, first segments and lengths are unchanged.

    mean, spread  of the curl radius [m]
    """
    curvatures = 1.0 / radii_of(groom.ids, mean, spread, seed)
    towards = np.pi * chances(seed, "curl direction", groom.ids)
    points = groom.points.copy()
    _curve(groom.points, groom.offsets, curvatures, towards, points)
    return replace(groom, points=points)


@njit(cache=True)
def _transport(vector: Vector, start: Vector, end: Vector) -> Vector:
    """Rotate a vector normal to start by the smallest rotation to end, another unit vector."""
    share = dot(vector, end) / max(1.0 + dot(start, end), _LEAST)
    return unit(minus(vector, scaled(share, plus(start, end))), vector)


@njit(cache=True, parallel=True)
def _curve(
    points: np.ndarray, offsets: np.ndarray, curvatures: np.ndarray, towards: np.ndarray, found: np.ndarray
) -> None:
    for s in prange(len(offsets) - 1):
        first = offsets[s]
        edge = minus(row(points, first + 1), row(points, first))
        before = length(edge)
        old = now = unit(edge, (0.0, -1.0, 0.0))
        aside = (1.0, 0.0, 0.0) if abs(old[0]) < 0.7 else (0.0, 1.0, 0.0)
        old_director = now_director = unit(minus(aside, scaled(dot(aside, old), old)), aside)
        for k in range(first + 1, offsets[s + 1] - 1):
            edge = minus(row(points, k + 1), row(points, k))
            after = length(edge)
            tangent = unit(edge, old)
            across = cross(old, old_director)
            turned = plus(
                scaled(dot(tangent, old), now),
                plus(
                    scaled(dot(tangent, old_director), now_director),
                    scaled(dot(tangent, across), cross(now, now_director)),
                ),
            )
            old_director = _transport(old_director, old, tangent)
            now_director = _transport(now_director, now, turned)
            angle = curvatures[s] * (before + after) / 2.0
            side = plus(
                scaled(np.cos(towards[s]), now_director), scaled(np.sin(towards[s]), cross(turned, now_director))
            )
            bent = unit(plus(scaled(np.cos(angle), turned), scaled(np.sin(angle), side)), turned)
            now_director = _transport(now_director, turned, bent)
            old = tangent
            now = bent
            before = after
            put(found, k + 1, plus(row(found, k), scaled(after, bent)))
