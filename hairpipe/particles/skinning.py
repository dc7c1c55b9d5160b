"""Hair deformed by particles: the vertices of a groom follow neighbouring particles, strand by strand.

    target_k = sum_i v_i a_i,   a_i = x_i + Q_i (X_k - X_i),   v_i = w_i / (|a_i - x_k-1|^2 + b^2)^2 over their sum,
    x_k = x_k-1 + l_k unit(target_k - x_k-1)

with Q_i below, and l_k the length of a segment at rest: lengths are exact, roots stay on the body, and rigid
motions are exact. Where particles separate, hair follows those near its present position, within b, half the reach of
links: otherwise it would cross the opening. Directions, sum_i w_i Q_i D_k, instead of targets have a larger error.
Velocities are the exact derivative. The groom may differ from the one of the particles.

Rigid motions of particles from rest, which deform their surroundings, and their time derivatives.

    x -> x_i + Q_i (x - X_i),   Q_i = M(R_i T_i, t_i) R_i

with R_i the rotation of the particle's root, T_i and t_i its direction at rest and now, and M(u, t) the smallest
rotation that maps u to t. Directions change like lines of a medium that moves with the particles,

    dt/dt = (1 - t t^T) G t,   min over G of sum w |v_ij - G x_ij|^2 + e |G - R'|^2

over the links of the particle, R' being the rotation rate of its root: rigid and affine motions are exact, and a
particle without links rotates with its root.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import blend, cross, dot, length, minus, plus, put, row, scaled
from hairpipe.groom.interpolating import go_on, moved
from hairpipe.groom.keys import columns_of, followed, spin_of
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.values import Cloud, Groom, Mesh, Particles, Strands
from hairpipe.values.triangles import normalized

_ROOT = 1e-3  # how much the turning of the root counts in G, over what all links do
_LEAST_AREA = 1e-20  # [m^2], what it counts where there is no link


def _rigid_motions(
    cloud: Cloud, particles: Particles, roots: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rigid motions of particles since rest, x -> Q x + s, and their derivatives, (N, 3, 4).

    roots  the same of the strands of the particles, (S, 3, 4) float64
    """
    count = len(cloud.points)
    if count != len(particles.points):
        what = f"a cloud of {count} particles, at rest there are {len(particles.points)}"
        raise BadInput(what, where="in.cloud", right="the cloud simulated from in.particles")
    spread, flow = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    _sum_links(particles.links, particles.alignments, particles.reach, cloud.points, cloud.velocities, spread, flow)
    motions, rates = np.empty((count, 3, 4)), np.empty((count, 3, 4))
    rest = particles.points, particles.directions
    now = cloud.points, cloud.velocities, cloud.directions
    _turn(particles.strands, roots, rest, now, spread, flow, motions, rates)
    return motions, rates


@njit(cache=True, error_model="numpy")
def _sum_links(links, alignments, reach, points, velocities, spread, flow):
    """Add w x_ij x_ij^T [m^2] and w v_ij x_ij^T [m^2/s] of all links to both of their particles, in place."""
    for e in range(len(links)):
        i, j = links[e]
        x, v = minus(row(points, j), row(points, i)), minus(row(velocities, j), row(velocities, i))
        near = max(0.0, 1.0 - dot(x, x) / (4.0 * reach * reach))
        weight = alignments[e] * near * near
        for k in (i, j):
            for a in range(3):
                for b in range(3):
                    spread[k, a, b] += weight * x[a] * x[b]
                    flow[k, a, b] += weight * v[a] * x[b]


@njit(cache=True, parallel=True, error_model="numpy")
def _turn(strands, roots, rest, now, spread, flow, motions, rates):
    """Write the motions and rates of all particles, in place."""
    for i in prange(len(strands)):
        R = columns_of(roots[0], strands[i])
        spin = spin_of(roots[0], roots[1], strands[i])
        t = row(now[2], i)
        Q, spin = followed(R, spin, row(rest[1], i), t, _speed(spread[i], flow[i], spin, t))
        X = row(rest[0], i)
        for j in range(3):
            put(motions[i].T, j, Q[j])
            put(rates[i].T, j, cross(spin, Q[j]))
        turned = blend(X, Q[0], Q[1], Q[2])
        put(motions[i].T, 3, minus(row(now[0], i), turned))
        put(rates[i].T, 3, minus(row(now[1], i), cross(spin, turned)))


@inlined
def _speed(spread, flow, spin, t):
    """G t, with G (spread + e) = flow + e [spin]x."""
    e = _ROOT * (spread[0, 0] + spread[1, 1] + spread[2, 2]) + _LEAST_AREA
    a = plus(row(spread, 0), (e, 0.0, 0.0))
    b = plus(row(spread, 1), (0.0, e, 0.0))
    c = plus(row(spread, 2), (0.0, 0.0, e))
    across = cross(b, c)
    y = scaled(1.0 / dot(a, across), (dot(t, across), dot(a, cross(t, c)), dot(a, cross(b, t))))
    moving = dot(row(flow, 0), y), dot(row(flow, 1), y), dot(row(flow, 2), y)
    return plus(moving, scaled(e, cross(spin, y)))


INFLUENCES = 7
"""Particles that carry a vertex, the nearest: weights end at the next one."""
_ASLANT = 1e-2  # least cosine that counts: where no particle points along, all of them carry
_TINY = 1e-9  # of that distance, by which weights end farther off


class Influences(NamedTuple):
    """Particles that deform the vertices of a groom.

    particles  (P, CARRIERS) int64
    weights    rows sum to 1, (P, CARRIERS) float64
    """

    particles: np.ndarray
    weights: np.ndarray


def find_influences(particles: Particles, groom: Groom) -> Influences:
    """Return the particles that deform the vertices of a groom, by w = (1 - d^2/d_8^2)^2 max(0.01, cos)^2; pure.

    d is the distance at rest, d_8 that of the eighth nearest, and cos that of the angle between both directions. Raises
    BadInput if there are fewer particles.
    """
    from scipy.spatial import KDTree  # here: a node that names this function is read without it

    if len(particles.points) <= INFLUENCES:
        what = f"{len(particles.points)} particles are too few for interpolation"
        raise BadInput(what, where="in.particles", right=f"more than {INFLUENCES}")
    distances, nearest = map(np.asarray, KDTree(particles.points).query(groom.points, k=INFLUENCES + 1))
    end = (1.0 + _TINY) * distances[:, INFLUENCES:] + _TINY
    counts = np.diff(groom.offsets)
    at = np.arange(len(groom.points))
    after = np.minimum(at + 1, np.repeat(groom.offsets[1:] - 1, counts))
    before = np.maximum(at - 1, np.repeat(groom.offsets[:-1], counts))
    tangents = normalized(groom.points[after] - groom.points[before])
    cosines = np.einsum("pi,pci->pc", tangents, particles.directions[nearest[:, :INFLUENCES]])
    weights = (1.0 - (distances[:, :INFLUENCES] / end) ** 2) ** 2 * np.maximum(cosines, _ASLANT) ** 2
    return Influences(nearest[:, :INFLUENCES], weights / weights.sum(axis=1, keepdims=True))


def deformed(
    groom: Groom, cloud: Cloud, particles: Particles, influences: Influences, body: Mesh | None, diameter: float
) -> Strands:
    """Return a groom at a frame, deformed by particles; pure.

    body      body of the roots of the groom and of the hair of the particles
    diameter  diameter of strands [m]

    Raises BadInput if the cloud or the body does not match.
    """
    turns = _rigid_motions(cloud, particles, motion_of_roots(body, particles.hair))
    points = np.empty_like(groom.points)
    velocities = np.empty((len(groom.points), 3), np.float32)
    roots = motion_of_roots(body, groom)
    near = (0.5 * particles.reach) ** 2
    _deform(influences, near, turns, roots, groom.points, groom.offsets, points, velocities)
    return Strands(points, velocities, groom.offsets, diameter)


@njit(cache=True, parallel=True, error_model="numpy")
def _deform(influences, near, turns, roots, rest, offsets, points, velocities):
    """Lay all strands down from their roots, in place; near is b^2 [m^2]."""
    for s in prange(len(offsets) - 1):
        X = row(rest, offsets[s])
        x, v = moved(roots[0], s, X), moved(roots[1], s, X)
        put(points, offsets[s], x)
        put(velocities, offsets[s], v)
        for k in range(offsets[s] + 1, offsets[s + 1]):
            before = X
            X = row(rest, k)
            way = speed = (0.0, 0.0, 0.0)
            total = change = 0.0
            for c in range(INFLUENCES):
                i = influences.particles[k, c]
                away, drift = minus(moved(turns[0], i, X), x), minus(moved(turns[1], i, X), v)
                far = 1.0 + dot(away, away) / near
                weight = influences.weights[k, c] / (far * far)
                rate = -4.0 * weight * dot(away, drift) / (far * near)
                total += weight
                change += rate
                way = plus(way, scaled(weight, away))
                speed = plus(speed, plus(scaled(weight, drift), scaled(rate, away)))
            way = scaled(1.0 / total, way)
            speed = scaled(1.0 / total, minus(speed, scaled(change, way)))
            x, v = go_on(x, v, length(minus(X, before)), way, speed)
            put(points, k, x)
            put(velocities, k, v)
