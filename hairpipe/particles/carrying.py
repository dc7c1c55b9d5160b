"""Hair carried by particles: the vertices of a groom as the particles beside them move, strand by strand.

    target_k = sum_i w_i (x_i + Q_i (X_k - X_i)),   x_k+1 = x_k + l_k unit(target_k+1 - x_k)

with Q_i of `turns`, and l_k the length of a segment at rest: lengths are exact, roots stay on the body, and hair that
is moved rigidly is right. Laid down by directions, sum_i w_i Q_i D_k, instead of by targets, hair is farther off.
Velocities are the derivative. The groom may be another one than particles lie on.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.data import Cloud, Groom, Mesh, Particles, Strands
from hairpipe.errors import BadInput
from hairpipe.groom.keys.interpolating import go_on, moved
from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import length, minus, row
from hairpipe.particles.turns import rigid_motions
from hairpipe.sim.boundary import motion_of_roots

CARRIERS = 7
"""Particles that carry a vertex, the nearest: weights end at the next one."""
_ASLANT = 1e-2  # least cosine that counts: where no particle points along, all of them carry
_TINY = 1e-9  # of that distance, by which weights end farther off


class Carriers(NamedTuple):
    """What carries the vertices of a groom.

    particles  (P, CARRIERS) int64
    weights    rows sum to 1, (P, CARRIERS) float64
    """

    particles: np.ndarray
    weights: np.ndarray


def weigh_carriers(particles: Particles, groom: Groom) -> Carriers:
    """Return which particles carry the vertices of a groom, by w = (1 - d^2/d_8^2)^2 max(0.01, cos)^2; pure.

    d is the distance at rest, d_8 that of the eighth nearest, and cos that of the angle between both directions. Raises
    BadInput where there are fewer particles.
    """
    from scipy.spatial import KDTree  # here: a node that names this function is read without it

    if len(particles.points) <= CARRIERS:
        what = f"{len(particles.points)} particles cannot carry hair"
        raise BadInput(what, where="in.particles", right=f"more than {CARRIERS}")
    distances, nearest = map(np.asarray, KDTree(particles.points).query(groom.points, k=CARRIERS + 1))
    end = (1.0 + _TINY) * distances[:, CARRIERS:] + _TINY
    cosines = np.einsum("pi,pci->pc", _tangents(groom), particles.directions[nearest[:, :CARRIERS]])
    weights = (1.0 - (distances[:, :CARRIERS] / end) ** 2) ** 2 * np.maximum(cosines, _ASLANT) ** 2
    return Carriers(nearest[:, :CARRIERS], weights / weights.sum(axis=1, keepdims=True))


def carried(
    groom: Groom, cloud: Cloud, particles: Particles, carriers: Carriers, body: Mesh | None, diameter: float
) -> Strands:
    """Return a groom at a frame, carried by particles; pure.

    body      that leads the roots of both the groom and the hair that particles lie on
    diameter  of strands [m]

    Raises BadInput where the cloud or the body is another one.
    """
    turns = rigid_motions(cloud, particles, motion_of_roots(body, particles.hair))
    points, velocities = np.empty_like(groom.points), np.empty((len(groom.points), 3), np.float32)
    _carry(carriers, turns, motion_of_roots(body, groom), groom.points, groom.offsets, points, velocities)
    return Strands(points, velocities, groom.offsets, diameter)


@njit(cache=True, parallel=True, error_model="numpy")
def _carry(
    carriers: Carriers,
    turns: tuple[np.ndarray, np.ndarray],
    roots: tuple[np.ndarray, np.ndarray],
    rest: np.ndarray,
    offsets: np.ndarray,
    points: np.ndarray,
    velocities: np.ndarray,
) -> None:
    """Lay all strands down from their roots, in place."""
    for s in prange(len(offsets) - 1):
        motion, rate = np.empty((1, 3, 4)), np.empty((1, 3, 4))
        X = row(rest, offsets[s])
        x, v = moved(roots[0], s, X), moved(roots[1], s, X)
        put(points, offsets[s], x)
        put(velocities, offsets[s], v)
        for k in range(offsets[s] + 1, offsets[s + 1]):
            before, X = X, row(rest, k)
            motion[:], rate[:] = 0.0, 0.0
            for c in range(CARRIERS):
                i, weight = carriers.particles[k, c], carriers.weights[k, c]
                for a in range(3):
                    for b in range(4):
                        motion[0, a, b] += weight * turns[0][i, a, b]
                        rate[0, a, b] += weight * turns[1][i, a, b]
            way, speed = minus(moved(motion, 0, X), x), minus(moved(rate, 0, X), v)
            x, v = go_on(x, v, length(minus(X, before)), way, speed)
            put(points, k, x)
            put(velocities, k, v)


def _tangents(groom: Groom) -> np.ndarray:
    """Return where hair goes at its vertices, root to tip, unit or 0, (P, 3)."""
    counts, at = np.diff(groom.offsets), np.arange(len(groom.points))
    after = np.minimum(at + 1, np.repeat(groom.offsets[1:] - 1, counts))
    before = np.maximum(at - 1, np.repeat(groom.offsets[:-1], counts))
    ways = groom.points[after] - groom.points[before]
    lengths = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.divide(ways, lengths, out=np.zeros_like(ways), where=lengths > 0.0)
