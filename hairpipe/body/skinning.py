"""The skin follows blend shapes and joints, by linear blending or dual quaternions, with velocities in closed form."""

import numpy as np
from numba import njit

from hairpipe.body.blend_shapes import displace
from hairpipe.body.dual_quaternions import blend_dual
from hairpipe.body.rigid import invert
from hairpipe.data import Body, Mesh, Pose
from hairpipe.errors import BadInput


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
