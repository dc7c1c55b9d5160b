"""The steps of a frame: links, air and bodies in one linearly implicit step each, or in explicit ones as printed.

With v' the velocities at the end of a step, and T the tension of the previous step,

    M (v' - v) = dt (M g + p - C v' + sum f_e),
    f_e = d (K (r - l) + dt K d . u' + c d . u') + dt max(T, 0) / r (u' - d d . u'),   T' = K (r - l + dt d . u')

over the links of a particle, u' being the velocity of the other end relative to this one, c = 2 zeta sqrt(K m) of the
reduced mass m; x' = x + dt v'. Particles below the skin move with their roots.

We differ from the paper, whose steps are explicit and in the frame of the head: this is stable with one step per
frame, and needs no inertial forces. Explicit steps, as Bando, Chen, Nishita 2003 take them, are symplectic Euler,

    v' = v + dt / m (M g + p - C v + sum f_e),   f_e = d (K (r - l) + c d . u),   x' = x + dt v'

where pairs, stiffness and directions (15) are updated in every step. Links are stable only for dt < 2 / omega of the
fastest oscillation: the number of steps per frame is proportional to the square root of the modulus, and to the number
of particles along a hair.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.vec3 import dot, minus, plus, row, scaled
from hairpipe.particles.contact import Planes, constrain, touch
from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.model import Model, Moving, inverse_masses
from hairpipe.particles.solve import build_system, set_block, solve

TOLERANCE = 1e-2
"""Tolerance of a solve over its change, in the norm of energy; links tear at a much larger one."""
STILL = 1e-4
"""Velocity below which nothing is solved more exactly [m/s]."""


class Springs(NamedTuple):
    """Parameters of links in a shot.

    axial    E A of every particle [N], (N,)
    rest     length of a link without tension [m], (E,)
    damping  fraction of critical damping
    """

    axial: np.ndarray
    rest: np.ndarray
    damping: float


class Forces(NamedTuple):
    """External forces on particles in a frame: push - drag v.

    push   [N], (N, 3)
    drag   symmetric xx xy xz yy yz zz [kg/s], (N, 6)
    """

    push: np.ndarray
    drag: np.ndarray


@njit(cache=True, error_model="numpy")
def advance(
    model: Model, springs: Springs, forces: Forces, planes: Planes, roots: np.ndarray, dt: float, moving: Moving
) -> int:
    """Compute the steps of a frame, in place; return the number of iterations.

    roots  positions of particles below the skin at the start of each step, and at the end [m], (steps + 1, deep, 3)
    dt     duration of a step [s]
    """
    links = model.links
    deep = model.deep
    count = len(model.masses)
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    made = 0
    still = STILL * STILL * (count - deep) * model.masses[deep]
    for step in range(len(roots) - 1):
        left = (len(roots) - 1 - step) * dt
        _set_out(model, springs, roots, step, dt, moving, ways, stiffness)
        system, residual = _assemble(model, springs, forces, moving, dt, ways, stiffness)
        change = np.zeros(4 * count, np.float32)
        constrain(system, planes, moving, left, dt, residual, change)
        made += solve(system, residual, change, TOLERANCE, still)
        for k in range(deep, count):
            for c in range(3):
                moving.velocities[k, c] += change[4 * k + c]
        for e in range(len(links.ends)):  # T' of this solve, which the next one takes.
            i, j = links.ends[e, 0], links.ends[e, 1]
            along = dot(row(ways, e), minus(row(moving.velocities, j), row(moving.velocities, i)))
            moving.tensions[e] = stiffness[e] * (ways[e, 3] - springs.rest[e] + dt * along)
        _move(deep, planes, roots, step, left, dt, moving)
    return made


@njit(cache=True, error_model="numpy")
def _set_out(model, springs, roots, step, dt, moving, ways, stiffness):
    """Set the velocities of particles below the skin, and measure links, at the start of a step, in place."""
    for k in range(model.deep):
        for c in range(3):
            moving.velocities[k, c] = (roots[step + 1, k, c] - roots[step, k, c]) / dt
    measure_links(model.links, moving.points, ways)
    stiffen(model.links, model.reach, springs.axial, ways, stiffness)


@njit(cache=True, error_model="numpy")
def _move(deep, planes, roots, step, left, dt, moving):
    """Move particles by their velocities, after contact with bodies, in place."""
    touch(planes, deep, left, dt, moving)
    for k in range(len(moving.points)):
        for c in range(3):
            x = moving.points[k, c] + dt * moving.velocities[k, c]
            moving.points[k, c] = x if k >= deep else roots[step + 1, k, c]


@njit(cache=True, error_model="numpy")
def _assemble(model, springs, forces, moving, dt, ways, stiffness):
    """Return the system of a step, and its residual where v' = v, (4 N,) float32."""
    links, masses, v = model.links, model.masses, moving.velocities
    push, drag = forces.push, forces.drag
    joins = np.empty(4 * len(links.ends), np.float32)
    pull = np.zeros(v.shape)
    inverses = inverse_masses(model)
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        d = row(ways, e)
        r = ways[e, 3]
        K = stiffness[e]
        across = dt * dt * max(moving.tensions[e], 0.0) / r if r > 0.0 else 0.0
        damper = 2.0 * springs.damping * np.sqrt(K / (inverses[i] + inverses[j]))
        # Not negative: B_e has to be positive semidefinite, and `joins` holds its root.
        along = max(dt * damper + dt * dt * K - across, 0.0)
        root = np.sqrt(along)  # sqrt(a) d: a product with d d^T is a dot product and a scaling of four numbers.
        u = minus(row(v, j), row(v, i))
        joins[4 * e + 3] = across
        force = plus(scaled(dt * K * (r - springs.rest[e]) + along * dot(d, u), d), scaled(across, u))
        for c in range(3):
            joins[4 * e + c] = root * d[c]
            pull[i, c] += force[c]
            pull[j, c] -= force[c]
    system = build_system(links, model.deep)
    residual = np.zeros(4 * len(masses), np.float32)
    for k in range(model.deep, len(masses)):
        xx = xy = xz = yy = yz = zz = 0.0
        for at in range(np.int64(links.rows[k]), np.int64(links.rows[k + 1])):
            e = 4 * np.int64(links.by[at])
            x = joins[e]
            y = joins[e + 1]
            z = joins[e + 2]
            across = joins[e + 3]
            for c in range(4):
                system.joins[4 * at + c] = joins[e + c]
            xx += x * x + across
            xy += x * y
            xz += x * z
            yy += y * y + across
            yz += y * z
            zz += z * z + across
        a, b, c = dt * drag[k, 0], dt * drag[k, 1], dt * drag[k, 2]
        d, e, f = dt * drag[k, 3], dt * drag[k, 4], dt * drag[k, 5]
        m = masses[k]
        set_block(system, k, (xx + a + m, xy + b, xz + c, yy + d + m, yz + e, zz + f + m))
        residual[4 * k] = pull[k, 0] + dt * push[k, 0] - (a * v[k, 0] + b * v[k, 1] + c * v[k, 2])
        residual[4 * k + 1] = pull[k, 1] + dt * push[k, 1] - (b * v[k, 0] + d * v[k, 1] + e * v[k, 2])
        residual[4 * k + 2] = pull[k, 2] + dt * push[k, 2] - (c * v[k, 0] + e * v[k, 1] + f * v[k, 2])
    return system, residual


def advance_explicitly(
    model: Model,
    springs: Springs,
    forces: Forces,
    planes: Planes,
    roots: np.ndarray,
    dt: float,
    moving: Moving,
    begin: Callable[[], None],
) -> None:
    """Compute explicit steps, in place, while particles are finite; arguments are those of `advance`.

    begin  called before every step: directions turn, and pairs change velocities
    """
    for step in range(len(roots) - 1):
        if not np.isfinite(moving.points).all():
            return
        begin()
        _step_explicitly(model, springs, forces, planes, roots, step, dt, moving)


@njit(cache=True, error_model="numpy")
def _step_explicitly(model, springs, forces, planes, roots, step, dt, moving):
    links, v, C = model.links, moving.velocities, forces.drag
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    inverses = inverse_masses(model)
    _set_out(model, springs, roots, step, dt, moving, ways, stiffness)
    total = forces.push.copy()
    for k in range(len(v)):
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
    for k in range(model.deep, len(v)):
        for c in range(3):
            v[k, c] += dt * inverses[k] * total[k, c]
    _move(model.deep, planes, roots, step, (len(roots) - 1 - step) * dt, dt, moving)
