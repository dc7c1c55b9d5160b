"""Poses of the parts of a body between two frames: a path through their poses, smooth at the frames.

    R(a) = R_0 exp(q(a)),  q = h10 w0 + h01 r + h11 J(r)^-1 w1,  p(a) = p_0 + h10 v0 + h01 (p_1 - p_0) + h11 v1

with r = log(R_0^T R_1), the velocities v and w (in the part's own frame) of the key poses times the frame, the right
Jacobian J of `turns`, and Hermite's h10 = a^3 - 2 a^2 + a, h01 = 3 a^2 - 2 a^3, h11 = a^3 - a^2. Poses and velocities
at the frames are the given ones, independent of other frames: the path is C1. A rotation by half a circle per frame is
ambiguous: the shorter one is used.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.body.rotations import exponential, inverse_jacobian, jacobian, logarithm


class PosePath(NamedTuple):
    """The paths of G parts."""

    turns: np.ndarray  # R_0, (G, 3, 3)
    places: np.ndarray  # p_0 [m], (G, 3)
    vectors: np.ndarray  # w0, r, J(r)^-1 w1 [rad], (3, G, 3)
    ways: np.ndarray  # v0, p_1 - p_0, v1 [m], (3, G, 3)
    frame: float  # [s]


class PartPoses(NamedTuple):
    """Poses and velocities of G parts at T times."""

    times: np.ndarray  # since the first frame [frames], (T,)
    turns: np.ndarray  # R, (T, G, 3, 3)
    places: np.ndarray  # p [m], (T, G, 3)
    spins: np.ndarray  # angular velocity in the world [rad/s], (T, G, 3)
    drifts: np.ndarray  # velocity of p [m/s], (T, G, 3)


def path_between(pose0: np.ndarray, rate0: np.ndarray, pose1: np.ndarray, rate1: np.ndarray, frame: float) -> PosePath:
    """Return the paths from one frame to the next; pure.

    pose0, pose1  [R | p] at the frames [m], (G, 3, 4);  rate0, rate1  their time derivatives
    frame         time between them [s]
    """
    vectors = np.empty((3, len(pose0), 3))
    for k in range(len(pose0)):
        start, end = pose0[k, :, :3], pose1[k, :, :3]
        vectors[0, k] = frame * spin_within(start, rate0[k, :, :3])
        vectors[1, k] = logarithm(start.T @ end)
        vectors[2, k] = frame * inverse_jacobian(vectors[1, k]) @ spin_within(end, rate1[k, :, :3])
    ways = np.stack([frame * rate0[:, :, 3], pose1[:, :, 3] - pose0[:, :, 3], frame * rate1[:, :, 3]])
    turns = np.ascontiguousarray(pose0[:, :, :3])
    places = np.ascontiguousarray(pose0[:, :, 3])
    return PosePath(turns, places, vectors, ways, frame)


def spin_within(turn: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return the angular velocity in its own frame [rad/s], (3,), of a rotation and its rate, (3, 3) each.

    Only the antisymmetric part of R^T dR/dt is used: a rate from finite differences also contains a small stretch.
    """
    W = turn.T @ rate
    return 0.5 * np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]])


@njit(cache=True)
def part_poses_at(path: PosePath, times: np.ndarray) -> PartPoses:
    """Return the parts at times since the first frame [s], (T,); pure."""
    count = len(times)
    parts = len(path.places)
    turns = np.empty((count, parts, 3, 3))
    places, spins, drifts = np.empty((count, parts, 3)), np.empty((count, parts, 3)), np.empty((count, parts, 3))
    found = PartPoses(np.empty(count), turns, places, spins, drifts)
    for t in range(count):
        a = times[t] / path.frame
        found.times[t] = a
        h = (a * (1.0 - a) ** 2, a * a * (3.0 - 2.0 * a), a * a * (a - 1.0))
        d = ((1.0 - a) * (1.0 - 3.0 * a), 6.0 * a * (1.0 - a), a * (3.0 * a - 2.0))
        for k in range(parts):
            vectors, ways = path.vectors[:, k], path.ways[:, k]
            q = h[0] * vectors[0] + h[1] * vectors[1] + h[2] * vectors[2]
            dq = d[0] * vectors[0] + d[1] * vectors[1] + d[2] * vectors[2]
            R = path.turns[k] @ exponential(q)
            found.turns[t, k] = R
            found.spins[t, k] = R @ (jacobian(q) @ dq) / path.frame
            found.places[t, k] = path.places[k] + h[0] * ways[0] + h[1] * ways[1] + h[2] * ways[2]
            found.drifts[t, k] = (d[0] * ways[0] + d[1] * ways[1] + d[2] * ways[2]) / path.frame
    return found
