"""Unit quaternions as arrays (..., 4), real part first; the rotation q and -q are the same."""

import numpy as np


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product a b, which turns by b first, broadcast (..., 4). Pure."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def about_axis(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the turn by angle [rad] (...) about unit axes (..., 3), (..., 4). Pure."""
    half = 0.5 * angle
    return np.concatenate([np.cos(half)[..., None], np.sin(half)[..., None] * axis], axis=-1)


def slerp(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the point `share` (...) of the way from a to b (..., 4) along the shorter great arc. Pure.

    Shoemake 1985: (sin((1-t) w) a + sin(t w) b) / sin(w), w the angle between a and b; linear where w vanishes.
    """
    cosine = np.einsum("...i,...i->...", a, b)
    b = np.where(cosine[..., None] < 0.0, -b, b)
    angle = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    sine = np.sin(angle)
    near = sine < 1e-9
    divisor = np.where(near, 1.0, sine)
    start = np.where(near, 1.0 - share, np.sin((1.0 - share) * angle) / divisor)
    end = np.where(near, share, np.sin(share * angle) / divisor)
    mixed = start[..., None] * a + end[..., None] * b
    return mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)


def to_matrix(q: np.ndarray) -> np.ndarray:
    """Return the rotation matrices (..., 3, 3), column vectors. Pure."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


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
