"""Vectors of three as tuples: inside kernels they live in registers, where small arrays would be allocated."""

import numpy as np
from numba import njit

Vector = tuple[float, float, float]


@njit(cache=True)
def row(array: np.ndarray, i: int) -> Vector:
    """Return row i of an array (n, 3)."""
    return array[i, 0], array[i, 1], array[i, 2]


@njit(cache=True)
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(cache=True)
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True)
def times(s: float, a: Vector) -> Vector:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@njit(cache=True)
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def length(a: Vector) -> float:
    """Return |a|."""
    return np.sqrt(dot(a, a))


@njit(cache=True)
def unit(a: Vector, otherwise: Vector) -> Vector:
    """Return a / |a|, or another vector where a is zero."""
    size = length(a)
    return times(1.0 / size, a) if size > 0.0 else otherwise


@njit(cache=True)
def mix(a: Vector, b: Vector, t: float) -> Vector:
    """Return a + t (b - a)."""
    return plus(a, times(t, minus(b, a)))


@njit(cache=True)
def blend(weights: Vector, a: Vector, b: Vector, c: Vector) -> Vector:
    """Return the sum of a, b and c, each times its weight."""
    return plus(plus(times(weights[0], a), times(weights[1], b)), times(weights[2], c))


@njit(cache=True)
def flattened(a: Vector, normal: Vector) -> Vector:
    """Return the part of a across a unit normal."""
    return minus(a, times(dot(a, normal), normal))


@njit(cache=True)
def any_across(a: Vector) -> Vector:
    """Return a vector across a, and across the axis that is least along it; zero where a is."""
    x, y, z = np.abs(a[0]), np.abs(a[1]), np.abs(a[2])
    if x <= y and x <= z:
        return (0.0, -a[2], a[1])
    if y <= z:
        return (a[2], 0.0, -a[0])
    return (-a[1], a[0], 0.0)
