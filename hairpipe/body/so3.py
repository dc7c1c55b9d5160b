"""Rotations as vectors, axis times angle [rad], and their rates: what a path of poses is made of.

J(r) maps the rate of such a vector to the angular velocity in the turned frame: the right Jacobian, exp(r)^T d exp(r) =
[J dr] (Chirikjian 2011, 10.86). All functions are pure.
"""

import numpy as np
from numba import njit

SMALL = 1e-3


@njit(cache=True)
def cross_matrix(r: np.ndarray) -> np.ndarray:
    """Return the matrix that takes y to r x y, (3, 3)."""
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
