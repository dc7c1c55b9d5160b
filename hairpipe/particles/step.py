"""The steps of a frame: links, air and bodies in one linearly implicit step each.

With v' the velocities at the end of a step, and T the tension that the last one found,

    M (v' - v) = dt (M g + p - C v' + sum f_e),
    f_e = d (K (r - l) + dt K d . u' + c d . u') + dt max(T, 0) / r (u' - d d . u'),   T' = K (r - l + dt d . u')

over the links of a particle, u' being the velocity of the other end against this one, c = 2 zeta sqrt(K m) of the
reduced mass m; x' = x + dt v'. Those below the skin go where their roots do.

We differ from the paper, whose steps are explicit and in the frame of the head: this is stable at a step a frame, and
finds inertia by itself.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import dot, flattened, length, minus, plus, row, scaled
from hairpipe.particles.contact import Planes, least_speed, rubbed
from hairpipe.particles.model import Model, Moving
from hairpipe.particles.solve import System, damp_across, inverted, multiply, precondition, solve, yielding
from hairpipe.particles.stiffness import measure_links, stiffen

TOLERANCE = 1e-2
"""Of the residual; links tear where it is 5e-2."""
STILL = 1e-4
"""Velocity below which nothing is solved more exactly, nor let go [m/s]."""
CREEP = 1e-4
"""Speed at which what does not slide gives way [m/s]."""
ROUNDS = 3
"""In which particles are let go that a body would have to pull at."""


class Springs(NamedTuple):
    """What links are like in a shot.

    axial    E A of every particle [N], (N,)
    rest     length at which a link has no tension [m], (E,)
    damping  a fraction of critical damping
    """

    axial: np.ndarray
    rest: np.ndarray
    damping: float


class Forces(NamedTuple):
    """What else acts on particles in a frame: the force push - drag v.

    push   [N], (N, 3)
    drag   symmetric xx xy xz yy yz zz [kg/s], (N, 6)
    """

    push: np.ndarray
    drag: np.ndarray


@njit(cache=True, error_model="numpy")
def advance(
    model: Model, springs: Springs, forces: Forces, planes: Planes, roots: np.ndarray, dt: float, moving: Moving
) -> int:
    """Do the steps of a frame, in place; return how many iterations they took.

    roots  where particles below the skin are as each step begins, and at the end [m], (steps + 1, deep, 3)
    dt     duration of a step [s]
    """
    links, deep, count, made = model.links, model.deep, len(model.masses), 0
    ways, stiffness = np.empty((len(links.ends), 4)), np.empty(len(links.ends))
    for step in range(len(roots) - 1):
        left = (len(roots) - 1 - step) * dt
        moving.velocities[:deep] = (roots[step + 1] - roots[step]) / dt
        measure_links(links, moving.points, ways)
        stiffen(links, model.reach, springs.axial, ways, stiffness)
        blocks, joins = np.empty((count, 6)), np.empty(4 * len(links.ends), np.float32)
        residual = _assemble(model, springs, forces, moving, dt, ways, stiffness, blocks, joins)
        system = System(links, deep, blocks, joins, inverted(blocks), np.zeros((count, 3)))
        change = np.zeros(4 * count, np.float32)
        _hold(system, planes, moving, left, dt, residual, change)
        made += _solve_with_bodies(system, model.masses, residual, change)
        for k in range(deep, count):
            for c in range(3):
                moving.velocities[k, c] += change[4 * k + c]
        for e in range(len(links.ends)):
            i, j = links.ends[e, 0], links.ends[e, 1]
            along = 0.0
            for c in range(3):
                along += ways[e, c] * (moving.velocities[j, c] - moving.velocities[i, c])
            moving.tensions[e] = stiffness[e] * (ways[e, 3] - springs.rest[e] + dt * along)
        _touch(system, planes, left, dt, moving)
        moving.points[deep:] += dt * moving.velocities[deep:]
        moving.points[:deep] = roots[step + 1]
    return made


@njit(cache=True, error_model="numpy")
def _assemble(model, springs, forces, moving, dt, ways, stiffness, blocks, joins):
    """Write blocks and joins of a system, in place; return its residual, (4 N,) float32, where v' = v."""
    links, masses, v = model.links, model.masses, moving.velocities
    pull = dt * forces.push
    for k in range(model.deep, len(masses)):
        D = forces.drag[k]
        pull[k, 0] -= dt * (D[0] * v[k, 0] + D[1] * v[k, 1] + D[2] * v[k, 2])
        pull[k, 1] -= dt * (D[1] * v[k, 0] + D[3] * v[k, 1] + D[4] * v[k, 2])
        pull[k, 2] -= dt * (D[2] * v[k, 0] + D[4] * v[k, 1] + D[5] * v[k, 2])
    for k in range(len(masses)):
        for c in range(6):
            blocks[k, c] = dt * forces.drag[k, c]
        blocks[k, 0] += masses[k]
        blocks[k, 3] += masses[k]
        blocks[k, 5] += masses[k]
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        x, y, z, r = ways[e, 0], ways[e, 1], ways[e, 2], ways[e, 3]
        over = (0.0 if i < model.deep else 1.0 / masses[i]) + (0.0 if j < model.deep else 1.0 / masses[j])
        K = stiffness[e]
        across = dt * dt * max(moving.tensions[e], 0.0) / r if r > 0.0 else 0.0
        along = max(2.0 * springs.damping * np.sqrt(K / over) * dt + dt * dt * K - across, 0.0)
        root = np.sqrt(along)
        joins[4 * e], joins[4 * e + 1], joins[4 * e + 2], joins[4 * e + 3] = root * x, root * y, root * z, across
        u, w, t = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
        s = dt * K * (r - springs.rest[e]) + along * (x * u + y * w + z * t)
        a, b, c = s * x + across * u, s * y + across * w, s * z + across * t
        for k, sign in ((i, 1.0), (j, -1.0)):
            pull[k, 0] += sign * a
            pull[k, 1] += sign * b
            pull[k, 2] += sign * c
            blocks[k, 0] += along * x * x + across
            blocks[k, 1] += along * x * y
            blocks[k, 2] += along * x * z
            blocks[k, 3] += along * y * y + across
            blocks[k, 4] += along * y * z
            blocks[k, 5] += along * z * z + across
    residual = np.zeros(4 * len(masses), np.float32)
    for k in range(model.deep, len(masses)):
        for c in range(3):
            residual[4 * k + c] = pull[k, c]
    return residual


@njit(cache=True, error_model="numpy")
def _hold(system, planes, moving, left, dt, residual, change):
    """Hold particles that would come too near to bodies by themselves, and move them as those do, in place.

    By what holds each alone its friction is known: a damper of mu times that over the speed at which it slides.
    """
    alone, held = np.zeros_like(change), 0
    precondition(system, residual, alone)
    for k in range(system.deep, len(system.blocks)):
        n, v = row(planes.normals, k), row(moving.velocities, k)
        least = least_speed(planes, k, row(moving.points, k), left, dt)
        ahead = dot(n, v) + n[0] * alone[4 * k] + n[1] * alone[4 * k + 1] + n[2] * alone[4 * k + 2]
        if ahead < least:
            held += 1
            u = flattened(minus(v, row(planes.drifts, k)), n)
            load = (least - ahead) / yielding(system.inverses, k, n)
            damper = planes.friction * load / max(length(u), CREEP)
            damp_across(system, k, n, damper)
            for c in range(3):
                system.normals[k, c] = n[c]
                residual[4 * k + c] -= damper * u[c]
                change[4 * k + c] = (least - dot(n, v)) * n[c]
    if held > 0:
        multiply(system, change, alone)
        for k in range(4 * system.deep, len(residual)):
            residual[k] -= alone[k]


@njit(cache=True, error_model="numpy")
def _solve_with_bodies(system, masses, residual, change):
    """Solve a system, letting go of particles that bodies would have to pull at, in place; return the iterations."""
    z, made, still = np.empty_like(change), 0, 0.0
    for k in range(system.deep, len(masses)):
        still += masses[k] * STILL * STILL
    size = max(TOLERANCE * TOLERANCE * precondition(system, residual, z), still)
    for _ in range(ROUNDS):
        made += solve(system, residual, change, size)
        let_go = 0
        for k in range(system.deep, len(masses)):
            if _push(system, residual, k) < -STILL * masses[k]:
                system.normals[k] = 0.0
                let_go += 1
        if let_go == 0:
            break
    return made


@inlined
def _push(system, residual, k):
    """Return the impulse of a body on particle k along its normal [N s]."""
    n = row(system.normals, k)
    return -(n[0] * residual[4 * k] + n[1] * residual[4 * k + 1] + n[2] * residual[4 * k + 2])


@njit(cache=True, error_model="numpy")
def _touch(system, planes, left, dt, moving):
    """Stop what came too near since, with the friction of that, in place."""
    for k in range(system.deep, len(system.blocks)):
        n, v = row(planes.normals, k), row(moving.velocities, k)
        missing = least_speed(planes, k, row(moving.points, k), left, dt) - dot(n, v)
        if missing > 0.0:
            v = rubbed(planes, k, plus(v, scaled(missing, n)), missing)
            moving.velocities[k, 0], moving.velocities[k, 1], moving.velocities[k, 2] = v
