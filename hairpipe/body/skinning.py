"""The skin follows blend shapes and joints, by linear blending or dual quaternions, with velocities in closed form.

A shape is linear between its keys, from 0 on. Dual quaternions blend turns of joints as turns, so that a twisted limb
keeps its volume.
"""

import numpy as np
from numba import njit
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import invert, multiply
from hairpipe.values import BlendShapes, Body, Mesh, Pose


def displace(rest: Body, pose: Pose) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the bound mesh with its blend shapes [m], (n, 3), and its velocities [m/s], None where it is still."""
    base = rest.mesh.points if rest.bound is None else rest.bound.points
    shapes = rest.shapes
    if shapes is None:
        return base, None
    weights = shapes.rest if pose.weights is None else pose.weights
    rates = np.zeros(len(weights)) if pose.weight_rates is None else pose.weight_rates
    if len(weights) != len(shapes.names):
        what = f"a pose of {len(weights)} weights, the body has {len(shapes.names)} blend shapes"
        raise BadInput(what, where="in.pose", right="a motion loaded for this body")
    shares, slopes = key_shares(shapes, weights)
    each = np.diff(shapes.rows)
    points = base.copy()
    drift = np.zeros_like(base)
    np.add.at(points, shapes.vertices, np.repeat(shares, each)[:, None] * shapes.offsets)
    np.add.at(drift, shapes.vertices, np.repeat(slopes * rates[shapes.shapes], each)[:, None] * shapes.offsets)
    return points, drift if rates.any() else None


def key_shares(shapes: BlendShapes, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the share of every key at weights (K,), and its slope over the weight, (m,) each.

    A shape of a mesh is linear between its keys and nothing at 0, and beyond the last keys as between the last two.
    """
    shares, slopes = np.zeros(len(shapes.places)), np.zeros(len(shapes.places))
    for shape, mesh in np.unique(np.stack([shapes.shapes, shapes.meshes], axis=1), axis=0):
        keys = np.flatnonzero((shapes.shapes == shape) & (shapes.meshes == mesh))
        order = np.argsort(shapes.places[keys])
        keys = np.insert(keys[order], np.searchsorted(shapes.places[keys[order]], 0.0), -1)  # -1: nothing, at 0
        places = np.where(keys < 0, 0.0, shapes.places[keys])
        at = int(np.clip(np.searchsorted(places, weights[shape], side="right") - 1, 0, len(keys) - 2))
        slope = 1.0 / (places[at + 1] - places[at])
        share = slope * (weights[shape] - places[at])
        for key, value, rate in ((keys[at], 1.0 - share, -slope), (keys[at + 1], share, slope)):
            if key >= 0:
                shares[key], slopes[key] = value, rate
    return shares, slopes


STEP = 1e-30  # imaginary step: its square is below the rounding of 1
SINGULAR = 1e-9  # sums of two scales of a joint that count as 0, relative to the largest


def blend_dual(
    points: np.ndarray,
    drift: np.ndarray | None,
    centres: np.ndarray,
    joints: np.ndarray,
    weights: np.ndarray,
    matrices: np.ndarray,
    rates: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) moved by joints [m], and their velocities [m/s], by motions of joints since rest, (J, 4, 4).

    M_j = [R_j S_j | t_j],  q_j + e d_j = (1 + e t_j / 2) R_j,  b = sum_j w_j (q_j + e d_j),  x = b / |b| acting on
    sum_j w_j S_j x_rest (Kavan, Collins, Zara, O'Sullivan 2007), from the centre of scale, where q_j has the sign that
    is nearer to the quaternion of the largest weight. Velocities: derivatives by a complex step (Squire, Trapp 1998).
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


def skin(rest: Body, pose: Pose | None) -> Mesh:
    """Return the body's mesh in a pose, with velocities; at rest and still without one. Pure.

    x = sum_j w_j T_j B_j^-1 x_rest,   v = sum_j w_j dT_j/dt B_j^-1 x_rest

    with the joints' transforms T_j and their rest transforms B_j (Magnenat-Thalmann et al. 1988); blend shapes move
    x_rest. See `blend_dual` for dual quaternions. Raise BadInput where the pose is that of another body.
    """
    mesh = rest.mesh
    if pose is None:
        return Mesh(mesh.points, mesh.triangles, np.zeros_like(mesh.points), mesh.uv)
    if len(pose.transforms) != len(rest.skeleton.names):
        what = f"a pose of {len(pose.transforms)} joints, the body has {len(rest.skeleton.names)}"
        raise BadInput(what, where="in.pose", right="a motion loaded for this body")
    unbind = invert(rest.skeleton.rest)
    unbind = unbind if rest.bound is None else unbind @ rest.bound.turns
    base, drift = displace(rest, pose)
    matrices, rates = pose.transforms @ unbind, pose.rates @ unbind
    points, velocities = np.empty_like(base), np.empty_like(base)
    blend(base, rest.joints, rest.weights, matrices, points)
    blend(base, rest.joints, rest.weights, rates, velocities)
    if drift is not None:
        turns = matrices.copy()
        turns[:, :3, 3] = 0.0
        turned = np.empty_like(base)
        blend(drift, rest.joints, rest.weights, turns, turned)
        velocities += turned
    if rest.dual is not None:
        dual, centres = rest.dual.vertices, rest.dual.centres
        moving = base[dual], None if drift is None else drift[dual]
        influences = rest.joints[dual], rest.weights[dual]
        points[dual], velocities[dual] = blend_dual(*moving, centres, *influences, matrices, rates)
    return Mesh(points, mesh.triangles, velocities, mesh.uv)


@njit(cache=True)
def blend(x: np.ndarray, joints: np.ndarray, weights: np.ndarray, M: np.ndarray, out: np.ndarray) -> None:
    """Write sum_k weights[i, k] M[joints[i, k]] (x[i], 1) to out (n, 3), in place; M (J, 4, 4)."""
    for i in range(x.shape[0]):
        for a in range(3):
            out[i, a] = 0.0
        for k in range(joints.shape[1]):
            w = weights[i, k]
            if w == 0.0:
                continue
            m = M[joints[i, k]]
            for a in range(3):
                out[i, a] += w * (m[a, 0] * x[i, 0] + m[a, 1] * x[i, 1] + m[a, 2] * x[i, 2] + m[a, 3])
