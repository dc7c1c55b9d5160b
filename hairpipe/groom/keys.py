"""Rotations of the segments of key hairs since rest, once per frame; the keys of every strand, and their weights.

With T_k the direction of a segment at rest, t_k now, and Q_0 = R the rotation of the root,

    Q_k = M(Q_{k-1} T_k, t_k) Q_{k-1},   w_k = w_M + M w_{k-1}

where M(u, t) is the smallest rotation that maps u to t: twist is transported along the hair and conserved. The w are
angular velocities.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import (
    Vector,
    any_across,
    blend,
    cross,
    dot,
    flattened,
    length,
    minus,
    plus,
    put,
    row,
    scaled,
    unit,
)
from hairpipe.values import Strands

_OPPOSED = 1e-8  # of 1 + u.t, below which u and t are opposed and no rotation is the smallest
_TINY = 1e-300


Columns = tuple[Vector, Vector, Vector]  # a rotation by its columns


class KeyTurns(NamedTuple):
    """Rotations of the segments of key hairs; rows are those of their points, the last of each key is unused."""

    turns: np.ndarray  # from rest, (P, 3, 3) float64
    spins: np.ndarray  # angular velocities [rad/s], (P, 3) float64
    offsets: np.ndarray  # of the points of keys, (K+1,) int32


def turns_since(rest: np.ndarray, now: Strands, motions: np.ndarray, rates: np.ndarray) -> KeyTurns:
    """Return the rotations of keys; pure.

    rest            points of the keys at rest [m], (P, 3) float64
    motions, rates  motions of their roots, x -> R x + t, and their time derivatives, (K, 3, 4) float64
    """
    turns = np.zeros((len(rest), 3, 3))
    spins = np.zeros((len(rest), 3))
    _propagate(rest, now.points, now.velocities, now.offsets, (motions, rates), turns, spins)
    return KeyTurns(turns, spins, now.offsets)


@njit(cache=True, parallel=True, error_model="numpy")
def _propagate(
    rest: np.ndarray,
    points: np.ndarray,
    velocities: np.ndarray,
    offsets: np.ndarray,
    roots: tuple[np.ndarray, np.ndarray],
    turns: np.ndarray,
    spins: np.ndarray,
) -> None:
    motions, rates = roots
    for g in prange(len(offsets) - 1):
        R = columns_of(motions, g)
        spin = spin_of(motions, rates, g)
        for k in range(offsets[g], offsets[g + 1] - 1):  # From the root on: the twist of each is that of all before it.
            T, speed = minus(row(rest, k + 1), row(rest, k)), minus(row(velocities, k + 1), row(velocities, k))
            R, spin = followed(R, spin, T, minus(row(points, k + 1), row(points, k)), speed)
            put(spins, k, spin)
            for j in range(3):
                turns[k, 0, j], turns[k, 1, j], turns[k, 2, j] = R[j]


@inlined
def followed(R: Columns, spin: Vector, T: Vector, way: Vector, speed: Vector) -> tuple[Columns, Vector]:
    """Return a rotation and its spin [rad/s], changed so that T lies along a way, which changes at a speed."""
    u = unit(blend(T, *R), T)
    t = unit(way, u)
    a = 1.0 + dot(u, t)
    if a < _OPPOSED:  # Opposed: half a turn about any axis across, since no smallest rotation is defined.
        axis = unit(any_across(u), u)
        return (_half_turn(axis, R[0]), _half_turn(axis, R[1]), _half_turn(axis, R[2])), spin
    du = cross(spin, u)
    dt = scaled(1.0 / max(length(way), _TINY), flattened(speed, t))
    c = cross(u, t)
    dc = plus(cross(du, t), cross(u, dt))
    da = dot(du, t) + dot(u, dt)
    # 2 dq/dt q* / |q|^2 of the quaternion q = (a, c) of that rotation
    own = scaled(1.0 / a, plus(minus(scaled(a, dc), scaled(da, c)), cross(c, dc)))
    return (_smallest(c, a, R[0]), _smallest(c, a, R[1]), _smallest(c, a, R[2])), plus(own, _smallest(c, a, spin))


@inlined
def columns_of(R: np.ndarray, g: int) -> Columns:
    """Return the rotation of rigid motion g of (K, 3, 4)."""
    return (
        (R[g, 0, 0], R[g, 1, 0], R[g, 2, 0]),
        (R[g, 0, 1], R[g, 1, 1], R[g, 2, 1]),
        (R[g, 0, 2], R[g, 1, 2], R[g, 2, 2]),
    )


@inlined
def spin_of(motions: np.ndarray, rates: np.ndarray, g: int) -> Vector:
    """Return the angular velocity of a rigid motion [rad/s]: half the sum of R_j x dR_j/dt over the columns."""
    R, dR = columns_of(motions, g), columns_of(rates, g)
    return scaled(0.5, plus(plus(cross(R[0], dR[0]), cross(R[1], dR[1])), cross(R[2], dR[2])))


@inlined
def _smallest(c: Vector, a: float, v: Vector) -> Vector:
    """Return v turned by the smallest rotation that takes u to t; c = u x t, a = 1 + u.t."""
    across = cross(c, v)
    return plus(plus(v, across), scaled(1.0 / a, cross(c, across)))


@inlined
def _half_turn(axis: Vector, v: Vector) -> Vector:
    return minus(scaled(2.0 * dot(axis, v), axis), v)


@inlined
def turned(turns: np.ndarray, k: int, v: Vector) -> Vector:
    """Return a vector turned by rotation k of (P, 3, 3)."""
    return (
        turns[k, 0, 0] * v[0] + turns[k, 0, 1] * v[1] + turns[k, 0, 2] * v[2],
        turns[k, 1, 0] * v[0] + turns[k, 1, 1] * v[1] + turns[k, 1, 2] * v[2],
        turns[k, 2, 0] * v[0] + turns[k, 2, 1] * v[1] + turns[k, 2, 2] * v[2],
    )


@inlined
def turned_back(turns: np.ndarray, k: int, v: Vector) -> Vector:
    """Return a vector turned by the inverse of rotation k of (P, 3, 3)."""
    return (
        turns[k, 0, 0] * v[0] + turns[k, 1, 0] * v[1] + turns[k, 2, 0] * v[2],
        turns[k, 0, 1] * v[0] + turns[k, 1, 1] * v[1] + turns[k, 2, 1] * v[2],
        turns[k, 0, 2] * v[0] + turns[k, 1, 2] * v[1] + turns[k, 2, 2] * v[2],
    )
