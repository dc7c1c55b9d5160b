"""Critical twist at which a straight rod buckles into a loop.

A rod clamped straight at both ends carries the torque M and the tension P. With w = y + i z its neighbours obey

    EI w'''' - i M w''' - P w'' = 0,   w = w' = 0 at both ends

(Greenhill 1883; Love, Mathematical Theory of Elasticity, 272). The loads at which a solution exists are eigenvalues:
1 / M is the largest one of  Q w = (1/M) (B + P T) w  with the quadratic forms Q, B, T of torque, bending and tension.
"""

from math import comb

import numpy as np

_MODES = 60


def buckling_torque(tension: float = 0.0) -> float:
    """Smallest torque that buckles a clamped-clamped rod, in units of EI / L; 8.9868 without tension.

    tension  P in units of EI / L^2, negative where the rod is pushed; above -4 pi^2, where it buckles without torque

    Galerkin's method with s^2 (1-s)^2 times Legendre polynomials: exact to rounding up to a tension of 400.
    """
    from numpy.polynomial import Polynomial, legendre
    from scipy.linalg import eigh

    if tension <= -4 * np.pi**2:
        raise ValueError("the rod buckles under this thrust without any torque")
    nodes, weights = legendre.leggauss(_MODES + 4)
    clamp = Polynomial([1, 0, -2, 0, 1])  # (1 - x^2)^2

    def basis(order: int) -> np.ndarray:
        coefficients = legendre.legder(np.eye(_MODES), order)
        return (legendre.legvander(nodes, len(coefficients) - 1) @ coefficients).T

    def values(order: int) -> np.ndarray:
        """Derivatives of the trial functions by s = (1 + x) / 2 at the nodes, (modes, nodes)."""
        parts = [comb(order, j) * clamp.deriv(j)(nodes) * basis(order - j) for j in range(order + 1)]
        return 2.0**order * np.sum(parts, axis=0)

    first, second = values(1), values(2)
    bend = second * weights @ second.T
    pull = first * weights @ first.T
    turn = first * weights @ second.T
    scale = 1 / np.sqrt(np.diag(bend))
    stiff = (bend + tension * pull) * np.outer(scale, scale)
    twisted = 1j * (turn - turn.T) / 2 * np.outer(scale, scale)
    return float(1 / eigh(twisted, stiff, eigvals_only=True)[-1])


def buckling_twist(length: float, bending: float, torsion: float, tension: float = 0.0) -> float:
    """Twist between the ends at which a clamped straight rod buckles, M L / GJ [rad].

    length [m], bending EI and torsion GJ [N m^2], tension [N]
    """
    return buckling_torque(tension * length**2 / bending) * bending / torsion
