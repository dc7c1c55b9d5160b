"""Stiffness of a spring in the matrix of a solve: K, and its tension T."""

from enum import IntEnum


class SpringForm(IntEnum):
    """The choices of K = (k / l0) d d^T + max(T, 0) / l (I - d d^T).

    explicit    K = 0: the force at the known positions; damping stays implicit
    printed     T = 0, Sec. 4.1 of Selle, Lentine, Fedkiw 2008: implicit along the spring only
    tension     T of the present stretch: stable, but the rotation of a stiff edge by theta within a step appears as a
                stretch by theta^2 / 2, and this spurious tension damps every swing
    multiplier  T of the previous solve: stable, without spurious tension
    """

    explicit = 0
    printed = 1
    tension = 2
    multiplier = 3
