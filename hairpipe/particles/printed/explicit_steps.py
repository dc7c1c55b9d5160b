"""Explicit steps, as Bando, Chen, Nishita 2003 take them: symplectic Euler.

    v' = v + dt / m (M g + p - C v + sum f_e),   f_e = d (K (r - l) + c d . u),   x' = x + dt v'

with the terms of the implicit step, `hairpipe/particles/step.py`, except that pairs, stiffness and directions (15) are
updated in every step. Links are stable only for dt < 2 / omega of the fastest oscillation: the number of steps per
frame is proportional to the square root of the modulus, and to the number of particles along a hair.
"""

from collections.abc import Callable

import numpy as np
from numba import njit

from hairpipe.kernels.vec3 import dot, minus, row
from hairpipe.particles.contact import Planes
from hairpipe.particles.model import Model, Moving, inverse_masses
from hairpipe.particles.step import Forces, Springs, touch
from hairpipe.particles.stiffness import measure_links, stiffen


def advance_explicitly(
    model: Model,
    springs: Springs,
    forces: Forces,
    planes: Planes,
    roots: np.ndarray,
    dt: float,
    moving: Moving,
    begin: Callable[[Moving, float], None],
) -> None:
    """Compute the steps of a frame, in place, while particles are finite; arguments are those of `advance`.

    begin  called before every step with its duration [s]: pairs change velocities, and directions turn
    """
    for step in range(len(roots) - 1):
        if not np.isfinite(moving.points).all():
            return
        begin(moving, dt)
        left = (len(roots) - 1 - step) * dt
        _step(model, springs, forces, planes, roots[step : step + 2], left, dt, moving)


@njit(cache=True, error_model="numpy")
def _step(model, springs, forces, planes, roots, left, dt, moving):
    """Do a step that begins so many seconds before the end of the frame, in place."""
    links = model.links
    deep = model.deep
    count = len(model.masses)
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    inverses = inverse_masses(model)
    measure_links(links, moving.points, ways)
    stiffen(links, model.reach, springs.axial, ways, stiffness)
    for k in range(deep):
        for c in range(3):
            moving.velocities[k, c] = (roots[1, k, c] - roots[0, k, c]) / dt
    total = forces.push.copy()
    v = moving.velocities
    C = forces.drag
    for k in range(count):
        total[k, 0] -= C[k, 0] * v[k, 0] + C[k, 1] * v[k, 1] + C[k, 2] * v[k, 2]
        total[k, 1] -= C[k, 1] * v[k, 0] + C[k, 3] * v[k, 1] + C[k, 4] * v[k, 2]
        total[k, 2] -= C[k, 2] * v[k, 0] + C[k, 4] * v[k, 1] + C[k, 5] * v[k, 2]
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        damper = 2.0 * springs.damping * np.sqrt(stiffness[e] / (inverses[i] + inverses[j]))
        moving.tensions[e] = stiffness[e] * (ways[e, 3] - springs.rest[e])
        force = moving.tensions[e] + damper * dot(row(ways, e), minus(row(v, j), row(v, i)))
        for c in range(3):
            total[i, c] += force * ways[e, c]
            total[j, c] -= force * ways[e, c]
    for k in range(deep, count):
        for c in range(3):
            v[k, c] += dt * inverses[k] * total[k, c]
    touch(planes, deep, left, dt, moving)
    for k in range(count):
        for c in range(3):
            moving.points[k, c] = moving.points[k, c] + dt * v[k, c] if k >= deep else roots[1, k, c]
