"""Rigid transforms, frames, rotations as vectors and as unit quaternions. All functions are pure.

A rotation vector is axis times angle [rad]; a path of poses is made of them. J(r) maps the rate of such a vector to the
angular velocity in the turned frame: the right Jacobian, exp(r)^T d exp(r) = [J dr] (Chirikjian 2011, 10.86).
Quaternions are arrays (..., 4), real part first; the rotation q and -q are the same. Vectors are columns.
"""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.vec3 import blend, cross, minus, row, unit

Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Takes Z up, face towards -Y, to Y up, face towards +Z."""

PARALLEL = 0.99  # cosine from which a direction counts as that of +Y


def frame_along(ahead: np.ndarray) -> np.ndarray:
    """Return a frame around a unit vector, (3, 3): columns up, sideways, ahead, right-handed. Pure."""
    up = np.array((0.0, 0.0, 1.0) if abs(ahead[1]) > PARALLEL else (0.0, 1.0, 0.0))
    up -= (up @ ahead) * ahead
    up /= np.linalg.norm(up)
    return np.column_stack([up, np.cross(ahead, up), ahead])


def invert(transforms: np.ndarray) -> np.ndarray:
    """Return the inverses of rotations with translations (..., 4, 4). Pure."""
    result = np.zeros_like(transforms)
    result[..., :3, :3] = np.swapaxes(transforms[..., :3, :3], -1, -2)
    result[..., :3, 3] = -np.einsum("...ji,...j->...i", transforms[..., :3, :3], transforms[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result


SMALL = 1e-3


@njit(cache=True)
def cross_matrix(r: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


@njit(cache=True)
def exponential(r: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) about r (3,) by its length: I + sin(t)/t [r] + (1 - cos t)/t^2 [r]^2 (Rodrigues)."""
    t = np.sqrt(np.sum(r * r))
    one, two = 1.0 - t * t / 6.0, 0.5 - t * t / 24.0
    if t > SMALL:  # Below, the quotients lose digits and the series does not.
        one = np.sin(t) / t
        two = (1.0 - np.cos(t)) / (t * t)
    K = cross_matrix(r)
    return np.eye(3) + one * K + two * (K @ K)


@njit(cache=True)
def logarithm(R: np.ndarray) -> np.ndarray:
    """Return the vector (3,) of a rotation, not longer than pi; by its quaternion, which half a turn does not hurt."""
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    q = np.array([1.0 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    i = np.argmax(np.array([R[0, 0], R[1, 1], R[2, 2]]))
    if R[i, i] > trace:  # By the largest component of the quaternion: nothing small is divided by.
        j, k = (i + 1) % 3, (i + 2) % 3
        q[0] = R[k, j] - R[j, k]
        q[1 + i] = 1.0 + R[i, i] - R[j, j] - R[k, k]
        q[1 + j], q[1 + k] = R[j, i] + R[i, j], R[k, i] + R[i, k]
    q = q if q[0] >= 0.0 else -q  # Of q and -q, one rotation, the shorter turn.
    sine = np.sqrt(np.sum(q[1:] ** 2))
    if sine < SMALL * SMALL * q[0]:
        return 2.0 * q[1:] / q[0]
    return 2.0 * np.arctan2(sine, q[0]) / sine * q[1:]


@njit(cache=True)
def jacobian(r: np.ndarray) -> np.ndarray:
    """Return J(r) = I - (1 - cos t)/t^2 [r] + (t - sin t)/t^3 [r]^2, (3, 3)."""
    t = np.sqrt(np.sum(r * r))
    one = 0.5 - t * t / 24.0
    two = 1.0 / 6.0 - t * t / 120.0
    if t > SMALL:  # Below, the quotients lose digits and the series does not.
        one = (1.0 - np.cos(t)) / (t * t)
        two = (t - np.sin(t)) / (t * t * t)
    K = cross_matrix(r)
    return np.eye(3) - one * K + two * (K @ K)


@njit(cache=True)
def inverse_jacobian(r: np.ndarray) -> np.ndarray:
    """Return J(r)^-1 = I + [r]/2 + (1 - t/2 cot(t/2))/t^2 [r]^2, (3, 3); t is at most pi."""
    t = np.sqrt(np.sum(r * r))
    two = 1.0 / 12.0 + t * t / 720.0
    if t > SMALL:
        two = (1.0 - 0.5 * t / np.tan(0.5 * t)) / (t * t)
    K = cross_matrix(r)
    return np.eye(3) + 0.5 * K + two * (K @ K)


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product a b, which turns by b first, broadcast (..., 4). Pure."""
    v, w, p, q = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([v * p - np.sum(w * q, axis=-1, keepdims=True), v * q + p * w + np.cross(w, q)], axis=-1)


def shortest_turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the rotation matrix (3, 3) of the smallest angle that takes direction `start` to `end`. Pure.

    Opposite directions are turned about an axis square to the start and nearest to Z.
    """
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    middle = start + end
    if np.linalg.norm(middle) < 1e-9:
        middle = np.cross(start, np.array([0.0, 0.0, 1.0]) if abs(start[2]) < 0.9 else np.array([1.0, 0.0, 0.0]))
    middle = middle / np.linalg.norm(middle)
    mirror = np.eye(3) - 2.0 * np.outer(middle, middle)
    return mirror @ (np.eye(3) - 2.0 * np.outer(start, start))


@njit(cache=True, parallel=True)
def root_frames(
    points: np.ndarray, triangles: np.ndarray, root_triangles: np.ndarray, root_barycentrics: np.ndarray
) -> np.ndarray:
    """Return the frames of roots on a mesh, (S, 3, 4) float64: columns tangent, bitangent, outward normal, origin [m].

    The tangent runs along the first edge of the triangle. At rest and in a pose it is the same function, so that the
    motion of a hair with the body is the product of one frame with the inverse of the other, which at rest is the
    identity.
    """
    frames = np.empty((len(root_triangles), 3, 4))
    for s in prange(len(root_triangles)):
        t = root_triangles[s]
        w = row(root_barycentrics, s)
        a, b, c = row(points, triangles[t, 0]), row(points, triangles[t, 1]), row(points, triangles[t, 2])
        ab = minus(b, a)
        tangent = unit(ab, (1.0, 0.0, 0.0))
        normal = unit(cross(ab, minus(c, a)), (0.0, 0.0, 1.0))
        bitangent = cross(normal, tangent)
        origin = blend(w, a, b, c)
        for k in range(3):
            frames[s, k, 0], frames[s, k, 1] = tangent[k], bitangent[k]
            frames[s, k, 2], frames[s, k, 3] = normal[k], origin[k]
    return frames
