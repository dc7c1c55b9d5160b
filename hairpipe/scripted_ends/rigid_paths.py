"""Rigid motions x -> R x + t of many points at once, (S, 3, 4), each with its rate of change."""

from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput

Vector = tuple[float, float, float]


class Motion(NamedTuple):
    """Motions, and their derivative by time [1/s, m/s]; columns of R and then t, (S, 3, 4) each."""

    place: np.ndarray
    rate: np.ndarray


class Course(NamedTuple):
    """Motion along and about an axis at one time: shift [m], its rate [m/s], turn [rad], its rate [rad/s]."""

    shift: np.ndarray
    shift_rate: np.ndarray
    turn: float
    turn_rate: float


def unit(vector: Vector, name: str) -> np.ndarray:
    """Scale a vector to length 1; BadInput for a zero vector."""
    length = np.linalg.norm(vector)
    if not length > 0.0:
        raise BadInput(f"{name} = {list(vector)} has no length", right="any other vector")
    return np.array(vector) / length


def turned(course: Course, axis: np.ndarray, pivots: np.ndarray) -> Motion:
    """Turn about an axis through every pivot, (S, 3) [m], and shift: x -> R (x - p) + p + s.

    R = I + sin(a) K + (1 - cos(a)) K^2 (Rodrigues), K y = axis x y; R' = a' K R.
    """
    K = np.cross(np.eye(3), axis)
    R = np.eye(3) + np.sin(course.turn) * K + (1.0 - np.cos(course.turn)) * K @ K
    dR = course.turn_rate * K @ R
    return Motion(
        with_shift(R, pivots - pivots @ R.T + course.shift), with_shift(dR, course.shift_rate - pivots @ dR.T)
    )


def with_shift(turn: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Put a matrix (3, 3) and shifts (S, 3) side by side, (S, 3, 4)."""
    turns = np.broadcast_to(turn, (len(shifts), 3, 3))
    return np.concatenate([turns, shifts[:, :, None]], axis=2)


def after(outer: Motion, inner: Motion) -> Motion:
    """Follow one motion by another: (A B)' = A' B + A B'."""
    place = product(outer.place, inner.place)
    place[:, :, 3] += outer.place[:, :, 3]
    rate = product(outer.rate, inner.place) + product(outer.place, inner.rate)
    rate[:, :, 3] += outer.rate[:, :, 3]
    return Motion(place, rate)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Multiply the matrices of one, (S, 3, 4), with all columns of the other."""
    return np.einsum("sij,sjk->sik", a[:, :, :3], b)
