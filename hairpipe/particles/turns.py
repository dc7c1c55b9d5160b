"""Rigid motions of particles from rest, which deform their surroundings, and their time derivatives.

    x -> x_i + Q_i (x - X_i),   Q_i = M(R_i T_i, t_i) R_i

with R_i the rotation of the particle's root, T_i and t_i its direction at rest and now, and M(u, t) the smallest
rotation that maps u to t. Directions change like lines of a medium that moves with the particles,

    dt/dt = (1 - t t^T) G t,   min over G of sum w |v_ij - G x_ij|^2 + e |G - R'|^2

over the links of the particle, R' being the rotation rate of its root: rigid and affine motions are exact, and a
particle without links rotates with its root.
"""

import numpy as np
from numba import njit, prange

from hairpipe.data import Cloud, Particles
from hairpipe.errors import BadInput
from hairpipe.groom.keys.key_turns import columns_of, followed, spin_of
from hairpipe.groom.resampling import put
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, blend, cross, dot, minus, plus, row, scaled

_ROOT = 1e-3  # how much the turning of the root counts in G, over what all links do
_TINY = 1e-20  # [m^2], what it counts where there is no link


def rigid_motions(
    cloud: Cloud, particles: Particles, roots: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rigid motions of particles since rest, x -> Q x + s, and their derivatives, (N, 3, 4); pure.

    roots  the same of the strands of the particles, (S, 3, 4) float64

    Raises BadInput if the cloud does not belong to these particles.
    """
    if len(cloud.points) != len(particles.points):
        what = f"a cloud of {len(cloud.points)} particles, at rest there are {len(particles.points)}"
        raise BadInput(what, where="in.cloud", right="the cloud simulated from in.particles")
    count = len(cloud.points)
    spread, flow = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    _sum_links(particles.links, particles.alignments, particles.reach, cloud.points, cloud.velocities, spread, flow)
    motions, rates = np.empty((count, 3, 4)), np.empty((count, 3, 4))
    rest = particles.points, particles.directions
    now = cloud.points, cloud.velocities, cloud.directions
    _turn(particles.strands, roots, rest, now, (spread, flow), motions, rates)
    return motions, rates


@njit(cache=True, error_model="numpy")
def _sum_links(
    links: np.ndarray,
    alignments: np.ndarray,
    reach: float,
    points: np.ndarray,
    velocities: np.ndarray,
    spread: np.ndarray,
    flow: np.ndarray,
) -> None:
    """Add w x_ij x_ij^T [m^2] and w v_ij x_ij^T [m^2/s] of all links to both of their particles, in place."""
    for e in range(len(links)):
        i, j = links[e]
        x, v = minus(row(points, j), row(points, i)), minus(row(velocities, j), row(velocities, i))
        near = max(0.0, 1.0 - dot(x, x) / (4.0 * reach * reach))
        weight = alignments[e] * near * near
        for a in range(3):
            for b in range(3):
                spread[i, a, b] += weight * x[a] * x[b]
                spread[j, a, b] += weight * x[a] * x[b]
                flow[i, a, b] += weight * v[a] * x[b]
                flow[j, a, b] += weight * v[a] * x[b]


@njit(cache=True, parallel=True, error_model="numpy")
def _turn(
    strands: np.ndarray,
    roots: tuple[np.ndarray, np.ndarray],
    rest: tuple[np.ndarray, np.ndarray],
    now: tuple[np.ndarray, np.ndarray, np.ndarray],
    sums: tuple[np.ndarray, np.ndarray],
    motions: np.ndarray,
    rates: np.ndarray,
) -> None:
    """Write the motions and rates of all particles, in place."""
    for i in prange(len(strands)):
        R = columns_of(roots[0], strands[i])
        spin = spin_of(roots[0], roots[1], strands[i])
        t = row(now[2], i)
        Q, spin = followed(R, spin, row(rest[1], i), t, _speed(sums[0][i], sums[1][i], spin, t))
        X = row(rest[0], i)
        for j in range(3):
            put(motions[i].T, j, Q[j])
            put(rates[i].T, j, cross(spin, Q[j]))
        turned = blend(X, Q[0], Q[1], Q[2])
        put(motions[i].T, 3, minus(row(now[0], i), turned))
        put(rates[i].T, 3, minus(row(now[1], i), cross(spin, turned)))


@inlined
def _speed(spread: np.ndarray, flow: np.ndarray, spin: Vector, t: Vector) -> Vector:
    """G t, with G (spread + e) = flow + e [spin]x."""
    e = _ROOT * (spread[0, 0] + spread[1, 1] + spread[2, 2]) + _TINY
    a, b, c = row(spread, 0), row(spread, 1), row(spread, 2)
    a = plus(a, (e, 0.0, 0.0))
    b = plus(b, (0.0, e, 0.0))
    c = plus(c, (0.0, 0.0, e))
    across = cross(b, c)
    y = scaled(1.0 / dot(a, across), (dot(t, across), dot(a, cross(t, c)), dot(a, cross(b, t))))
    moving = dot(row(flow, 0), y), dot(row(flow, 1), y), dot(row(flow, 2), y)
    return plus(moving, scaled(e, cross(spin, y)))
