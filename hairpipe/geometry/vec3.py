"""Vectors of three as tuples, of floats or of lanes: in registers, where a small array would be allocated.

One definition serves a kernel that follows a list and one that computes a strand per lane (`geometry/simd.py`): numba
compiles it for either kind of number.
"""

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined

Vector = tuple[float, float, float]
"""Three floats; where lanes are computed, three lanes. `row`, `length`, `unit` and `any_across` take floats alone."""


@inlined
def row(array: np.ndarray, i: int) -> Vector:
    """Return row i of an array (n, 3)."""
    return array[i, 0], array[i, 1], array[i, 2]


@inlined
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def scaled(s: float, a: Vector) -> Vector:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def length(a: Vector) -> float:
    """Return |a|."""
    return np.sqrt(dot(a, a))


@inlined
def unit(a: Vector, otherwise: Vector) -> Vector:
    """Return a / |a|, or another vector where a is zero."""
    size = length(a)
    return scaled(1.0 / size, a) if size > 0.0 else otherwise


@inlined
def mix(a: Vector, b: Vector, t: float) -> Vector:
    """Return a + t (b - a)."""
    return plus(a, scaled(t, minus(b, a)))


@inlined
def blend(weights: Vector, a: Vector, b: Vector, c: Vector) -> Vector:
    """Return the sum of a, b and c, each times its weight."""
    return plus(plus(scaled(weights[0], a), scaled(weights[1], b)), scaled(weights[2], c))


@inlined
def flattened(a: Vector, normal: Vector) -> Vector:
    """Return the part of a across a unit normal."""
    return minus(a, scaled(dot(a, normal), normal))


@inlined
def any_across(a: Vector) -> Vector:
    """Return a vector across a, and across the axis that is least along it; zero where a is."""
    x, y, z = np.abs(a[0]), np.abs(a[1]), np.abs(a[2])
    if x <= y and x <= z:
        return (0.0, -a[2], a[1])
    if y <= z:
        return (a[2], 0.0, -a[0])
    return (-a[1], a[0], 0.0)


@njit(cache=True)
def put(array: np.ndarray, i: int, a: Vector) -> None:
    """Write a vector into row i of an array (n, 3), in place."""
    array[i, 0], array[i, 1], array[i, 2] = a
