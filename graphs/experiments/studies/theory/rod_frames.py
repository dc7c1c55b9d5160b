"""Rotations along a rod as quaternions (w, x, y, z), first axis; a rotation's columns are the directors d1, d2, d3.

Products are matrices, q p = left(q) p = right(p) q, since the solver needs their derivatives.
"""

import numpy as np

CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def left(q: np.ndarray) -> np.ndarray:
    """Matrix of p -> q p, (4, 4, ...), for q (4, ...)."""
    w, x, y, z = q
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


def right(q: np.ndarray) -> np.ndarray:
    """Matrix of p -> p q, (4, 4, ...), for q (4, ...)."""
    w, x, y, z = q
    return np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])


def tangents(q: np.ndarray) -> np.ndarray:
    """Third directors, (3, ...), of unit quaternions (4, ...)."""
    w, x, y, z = q
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z])


def tangent_slopes(q: np.ndarray) -> np.ndarray:
    """Derivative of `tangents` by the quaternion, (3, 4, ...)."""
    w, x, y, z = 2 * q
    return np.array([[y, z, w, x], [-x, -w, z, y], [w, -x, -y, z]])


def frames_of(q: np.ndarray) -> np.ndarray:
    """Rotation matrices, (n, 3, 3), of unit quaternions (4, n)."""
    turned = np.einsum("ijn,jkn->nik", left(q), right(q * CONJUGATE[:, None]))
    return turned[:, 1:, 1:]


def quaternion_of(frame: np.ndarray) -> np.ndarray:
    """Unit quaternion, (4,), of a rotation matrix, (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(frame).as_quat()
    return np.array([w, x, y, z])
