"""The smoothing kernel, equation (2) of Bando, Chen, Nishita 2003: Monaghan's cubic spline.

    W(r, h) = 1 / (4 pi h^3) (4 - 6 q^2 + 3 q^3)   q = r / h <= 1
                             (2 - q)^3             1 <= q <= 2
                             0                     beyond

Its integral over space is 1, and W(0, h) = 1 / (pi h^3).
"""

import numpy as np

from hairpipe.kernels.compile import inlined


@inlined
def shape(q):
    """Return 4 pi h^3 W(q h, h); for numbers and, in numpy, for arrays of them."""
    far, near = max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return far * far * far - 4.0 * near * near * near


@inlined
def slope(q):
    """Return its derivative by q."""
    far, near = max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return 12.0 * near * near - 3.0 * far * far


def kernel(r: np.ndarray, h: float) -> np.ndarray:
    """Return W [1/m^3] at distances [m], (n,); pure."""
    far, near = np.maximum(2.0 - r / h, 0.0), np.maximum(1.0 - r / h, 0.0)
    return (far**3 - 4.0 * near**3) / (4.0 * np.pi * h**3)
