"""Linear blend skinning: the skin follows its joints, with velocities in closed form."""

import numpy as np
from numba import njit

from hairpipe.body.rigid import invert
from hairpipe.data import Body, Mesh, Pose
from hairpipe.errors import BadInput


def skin(rest: Body, pose: Pose | None) -> Mesh:
    """Return the body's mesh in a pose, with velocities; at rest and still without one. Pure.

    x = sum_j w_j T_j B_j^-1 x_rest,   v = sum_j w_j dT_j/dt B_j^-1 x_rest

    with the joints' transforms T_j and their rest transforms B_j (Magnenat-Thalmann et al. 1988). Raise BadInput where
    the pose is that of another skeleton.
    """
    mesh = rest.mesh
    if pose is None:
        return Mesh(mesh.points, mesh.triangles, np.zeros_like(mesh.points), mesh.uv)
    if len(pose.transforms) != len(rest.skeleton.names):
        what = f"a pose of {len(pose.transforms)} joints, the body has {len(rest.skeleton.names)}"
        raise BadInput(what, where="in.pose", right="a motion loaded for this body")
    unbind = invert(rest.skeleton.rest)
    moved = np.empty_like(mesh.points), np.empty_like(mesh.points)
    for matrices, result in zip((pose.transforms, pose.rates), moved, strict=True):
        blend(mesh.points, rest.joints, rest.weights, matrices @ unbind, result)
    return Mesh(moved[0], mesh.triangles, moved[1], mesh.uv)


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
