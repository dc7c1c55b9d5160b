"""Hair deformed by particles: the vertices of a groom follow neighbouring particles, strand by strand.

    target_k = sum_i v_i a_i,   a_i = x_i + Q_i (X_k - X_i),   v_i = w_i / (|a_i - x_k-1|^2 + b^2)^2 over their sum,
    x_k = x_k-1 + l_k unit(target_k - x_k-1)

with Q_i of `turns`, and l_k the length of a segment at rest: lengths are exact, roots stay on the body, and rigid
motions are exact. Where particles separate, hair follows those near its present position, within b, half the reach of
links: otherwise it would cross the opening. Directions, sum_i w_i Q_i D_k, instead of targets have a larger error.
Velocities are the exact derivative. The groom may differ from the one of the particles.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.data import Cloud, Groom, Mesh, Particles, Strands
from hairpipe.errors import BadInput
from hairpipe.groom.keys.interpolating import go_on, moved
from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import dot, length, minus, plus, row, scaled
from hairpipe.particles.turns import rigid_motions
from hairpipe.sim.boundary import motion_of_roots

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
    cosines = np.einsum("pi,pci->pc", _tangents(groom), particles.directions[nearest[:, :INFLUENCES]])
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
    turns = rigid_motions(cloud, particles, motion_of_roots(body, particles.hair))
    points = np.empty_like(groom.points)
    velocities = np.empty((len(groom.points), 3), np.float32)
    roots = motion_of_roots(body, groom)
    near = (0.5 * particles.reach) ** 2
    _deform(influences, near, turns, roots, groom.points, groom.offsets, points, velocities)
    return Strands(points, velocities, groom.offsets, diameter)


@njit(cache=True, parallel=True, error_model="numpy")
def _deform(
    influences: Influences,
    near: float,
    turns: tuple[np.ndarray, np.ndarray],
    roots: tuple[np.ndarray, np.ndarray],
    rest: np.ndarray,
    offsets: np.ndarray,
    points: np.ndarray,
    velocities: np.ndarray,
) -> None:
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


def _tangents(groom: Groom) -> np.ndarray:
    """Return where hair goes at its vertices, root to tip, unit or 0, (P, 3)."""
    counts = np.diff(groom.offsets)
    at = np.arange(len(groom.points))
    after = np.minimum(at + 1, np.repeat(groom.offsets[1:] - 1, counts))
    before = np.maximum(at - 1, np.repeat(groom.offsets[:-1], counts))
    ways = groom.points[after] - groom.points[before]
    lengths = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.divide(ways, lengths, out=np.zeros_like(ways), where=lengths > 0.0)
