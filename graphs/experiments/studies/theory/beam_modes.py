"""Small vibrations of a straight rod clamped at one end."""

import numpy as np


def bending_roots(count: int) -> np.ndarray:
    """First roots of cos(b) cosh(b) = -1, (count,): 1.8751, 4.6941, 7.8548, ... (Rayleigh, Theory of Sound, 174)."""
    from scipy.optimize import brentq

    def characteristic(b: float) -> float:
        return np.cos(b) + 1 / np.cosh(b)

    return np.array([brentq(characteristic, np.pi * n, np.pi * (n + 1), xtol=1e-14) for n in range(count)])


def bending_frequencies(count: int, length: float, bending: float, line_density: float) -> np.ndarray:
    """Frequencies of an Euler-Bernoulli rod, f = b^2 sqrt(EI / (rho A)) / (2 pi L^2) [Hz], (count,).

    length [m], bending EI [N m^2], line_density rho A [kg/m]
    """
    return bending_roots(count) ** 2 * np.sqrt(bending / line_density) / (2 * np.pi * length**2)


def bending_shape(mode: int, s: np.ndarray) -> np.ndarray:
    """Deflection of bending mode 0, 1, ... at s = 0 ... 1 along the rod, of the shape of s (Rayleigh, 174)."""
    b = bending_roots(mode + 1)[-1]
    ratio = (np.cos(b) + np.cosh(b)) / (np.sin(b) + np.sinh(b))
    return np.cosh(b * s) - np.cos(b * s) - ratio * (np.sinh(b * s) - np.sin(b * s))
