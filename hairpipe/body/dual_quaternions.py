"""Dual quaternion skinning: turns of joints are blended as turns, so that a twisted limb keeps its volume."""

import numpy as np
from scipy.spatial.transform import Rotation

from hairpipe.body.mocap.quaternion import multiply

STEP = 1e-30
"""Imaginary step: its square is below the rounding of 1."""
SINGULAR = 1e-9
"""Sums of two scales of a joint that count as 0, relative to the largest."""


def blend_dual(
    points: np.ndarray,
    drift: np.ndarray | None,
    centres: np.ndarray,
    joints: np.ndarray,
    weights: np.ndarray,
    matrices: np.ndarray,
    rates: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points moved by joints [m] and their velocities [m/s], (n, 3) each. Pure.

    M_j = [R_j S_j | t_j],  q_j + e d_j = (1 + e t_j / 2) R_j,  b = sum_j w_j (q_j + e d_j),  x = b / |b| acting on
    sum_j w_j S_j x_rest (Kavan, Collins, Zara, O'Sullivan 2007), from the centre of scale, where q_j has the sign that
    is nearer to the quaternion of the largest weight. Velocities: derivatives by a complex step (Squire, Trapp 1998).

    points, drift    the bound mesh [m] and its velocities [m/s], (n, 3); no drift is a still one
    centres          points about which joints scale [m], (n, 3)
    joints, weights  of every point, (n, k)
    matrices, rates  motions of the joints since rest [m] and their time derivatives, (J, 4, 4)
    """
    turns, stretches = split(matrices[:, :3, :3], rates[:, :3, :3])
    M = matrices[:, :3] + 1j * STEP * rates[:, :3]
    pivots = turns.real[np.take_along_axis(joints, weights.argmax(axis=1)[:, None], axis=1)]
    signs = np.where(
        np.einsum("nki,nki->nk", turns.real[joints], np.broadcast_to(pivots, (*joints.shape, 4))) < 0, -1, 1
    )
    signed = signs * weights
    q = np.einsum("nk,nki->ni", signed, turns[joints])
    along = np.einsum("nkij,nj->nki", M[joints, :, :3], centres) + M[joints, :, 3]
    along = np.concatenate([np.zeros((*joints.shape, 1)), along], axis=2)
    d = np.einsum("nk,nki->ni", signed, 0.5 * multiply(along, turns[joints]))
    x = points - centres if drift is None else points - centres + 1j * STEP * drift
    x = np.einsum("nk,nkij,nj->ni", weights, stretches[joints], x)
    real, vector = q[:, :1], q[:, 1:]
    moved = np.cross(vector, np.cross(vector, x) + real * x)
    moved += real * d[:, 1:] - d[:, :1] * vector + np.cross(vector, d[:, 1:])
    moved = 2.0 * moved / np.einsum("ni,ni->n", q, q)[:, None]
    moved += x
    return moved.real.copy(), moved.imag / STEP


def split(matrices: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return M = R S as quaternions of R, (J, 4), and S, (J, 3, 3); their rates are imaginary parts, by `STEP`. Pure.

    R is the nearest rotation and S symmetric. With a spin w of R in its frame, and A = R^T dM/dt, the skew part of
    [w] S + dS/dt = A is (tr(S) I - S) w = axial(A - A^T), and w the smallest solution where scales are 0 or mirror.
    """
    left, sizes, right = np.linalg.svd(matrices)
    handed = np.linalg.det(left @ right)
    left[:, :, 2] *= handed[:, None]
    sizes[:, 2] *= handed
    R = left @ right
    S = right.swapaxes(1, 2) @ (sizes[:, :, None] * right)
    A = R.swapaxes(1, 2) @ rates
    skew = A - A.swapaxes(1, 2)
    axial = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    inertia = np.trace(S, axis1=1, axis2=2)[:, None, None] * np.eye(3) - S
    spins = (np.linalg.pinv(inertia, rcond=SINGULAR, hermitian=True) @ axial[:, :, None])[:, :, 0]
    turning = np.cross(spins[:, :, None], S, axis=1)
    quaternions = np.roll(Rotation.from_matrix(R).as_quat(), 1, axis=1)
    spinning = multiply(quaternions, np.concatenate([np.zeros((len(spins), 1)), 0.5 * spins], axis=1))
    return quaternions + 1j * STEP * spinning, S + 1j * STEP * (A - turning)
