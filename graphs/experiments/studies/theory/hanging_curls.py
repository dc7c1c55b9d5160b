"""A rod that is curved by nature and hangs from a clamp: the planar curl, where it leaves its plane, and its helix.

In units of the length L and of EI / L, with the angle a of the tangent from the vertical, w = rho A g L^3 / (EI), the
natural curvature k and c = GJ / EI. The planar curl, a hook or a coil, is

    a'' = w (1 - s) sin a,   a(0) = 0,   a'(1) = k

A small rotation phi = p d1 + q t of its sections, d1 in the plane and t the tangent, has the energy of second order

    1/2 int (p' + a' q)^2 + c (q' - a' p)^2 + (a' - k) ((q' - a' p) p - (p' + a' q) q)
          + w (1 - s) (p^2 cos a + p q sin a) ds,   p(0) = q(0) = 0

whose least eigenvalue is zero where the curl leaves its plane: R = R0 exp phi in the strains of Kirchhoff's rod. A
rotation about the vertical, p = -sin a and q = cos a, costs nothing, as it must.

Where the tension T changes little in a turn, the rod is locally a helix without a torque about its axis, as its end is
free. With x the cosine between tangent and axis, the energy per length 1/2 c k^2 x^2 / (1 - (1 - c) x^2) - T x has one
minimum in x,

    c k^2 x / (1 - (1 - c) x^2)^2 = T,   turn per length = k sqrt(1 - x^2) / (1 - (1 - c) x^2)

and x = 1, a straight rod, for T >= k^2 / c: a helix as long as k^2 / (c w), or the whole rod.

Source: Miller, Lazarus, Audoly, Reis, Shapes of a Suspended Curly Hair, Phys. Rev. Lett. 112, 068103, 2014, for the
problem; equations and numbers are derived here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre

_TOLERANCE = 1e-9
_MODES, _PLACES = 48, 200
"""Polynomials of each component of a rotation, and places of the quadrature."""
_FACTOR = 1.1
"""From one curvature or weight of a continuation to the next."""


@dataclass(frozen=True, eq=False)
class PlanarCurl:
    """A planar curl of length 1: natural curvature, weight, and the solution of angle and curvature over the arc."""

    curvature: float
    weight: float
    solution: Any

    @property
    def tip(self) -> np.ndarray:
        """Free end, aside and down, (2,)."""
        s, share = legendre.leggauss(_PLACES)
        angle = self.solution((s + 1) / 2)[0]
        return np.array([np.sin(angle) @ share, np.cos(angle) @ share]) / 2


def bend_curl(curvature: float, weight: float, guess: PlanarCurl | None = None) -> PlanarCurl:
    """Solve a planar curl near a guess, by default near the arc without weight; ArithmeticError without a solution."""
    from scipy.integrate import solve_bvp

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.stack([y[1], weight * (1 - s) * np.sin(y[0])])

    def jacobian(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        matrix = np.zeros((2, 2, len(s)))
        matrix[0, 1] = 1.0
        matrix[1, 0] = weight * (1 - s) * np.cos(y[0])
        return matrix

    def ends(start: np.ndarray, end: np.ndarray) -> np.ndarray:
        return np.array([start[0], end[1] - curvature])

    arc = np.linspace(0.0, 1.0, 201)
    state = np.stack([curvature * arc, np.full_like(arc, curvature)]) if guess is None else guess.solution(arc)
    found = solve_bvp(slope, ends, arc, state, fun_jac=jacobian, tol=_TOLERANCE, max_nodes=50_000)
    if not found.success:
        raise ArithmeticError(f"no planar curl of curvature {curvature:g} and weight {weight:g}: {found.message}")
    return PlanarCurl(curvature, weight, found.sol)


def least_variation(curl: PlanarCurl, ratio: float) -> float:
    """Return the least eigenvalue of the second variation out of the plane, whose sign is that of its stability.

    ratio  GJ / EI
    """
    from scipy.linalg import eigh

    at, share = legendre.leggauss(_PLACES)
    s = (at + 1) / 2
    share = share / 2
    angle, bend = curl.solution(s)
    unit = np.eye(_MODES)
    mode = legendre.legval(at, unit)
    shape = s * mode
    slope = mode + 2 * s * np.stack([legendre.legval(at, legendre.legder(row)) for row in unit])
    nothing = np.zeros_like(shape)
    p, q = np.vstack([shape, nothing]), np.vstack([nothing, shape])
    bent = np.vstack([slope, nothing]) + bend * q
    twisted = np.vstack([nothing, slope]) - bend * p
    tension = curl.weight * (1 - s)

    def form(first: np.ndarray, second: np.ndarray, weight: np.ndarray | float = 1.0) -> np.ndarray:
        matrix = (first * (share * weight)) @ second.T
        return (matrix + matrix.T) / 2

    energy = form(bent, bent) + ratio * form(twisted, twisted)
    energy += form(twisted, p, bend - curl.curvature) - form(bent, q, bend - curl.curvature)
    energy += form(p, p, tension * np.cos(angle)) + form(p, q, tension * np.sin(angle))
    return float(eigh(energy, form(p, p) + form(q, q), eigvals_only=True, subset_by_index=[0, 0])[0])


def leaving_curvature(weight: float, ratio: float) -> float:
    """Return the natural curvature, over 1 / L, at which a hook of this weight leaves its plane, from straight on."""
    hook = bend_curl(0.1, weight)
    while least_variation(further := bend_curl(_FACTOR * hook.curvature, weight, hook), ratio) > 0.0:
        hook = further
    return _root(lambda k: least_variation(bend_curl(k, weight, hook), ratio), hook.curvature, further.curvature)


def leaving_weight(curvature: float, ratio: float) -> float:
    """Return the weight at which a coil of this natural curvature leaves its plane, from none on."""
    coil = bend_curl(curvature, 1.0)
    while least_variation(further := bend_curl(curvature, _FACTOR * coil.weight, coil), ratio) > 0.0:
        coil = further
    return _root(lambda w: least_variation(bend_curl(curvature, w, coil), ratio), coil.weight, further.weight)


def _root(of: Callable[[float], float], low: float, high: float) -> float:
    """Return the root between two places to the precision of the tables."""
    from scipy.optimize import root_scalar

    return float(root_scalar(of, bracket=(low, high), rtol=1e-6).root)


def local_helix(tension: np.ndarray, curvature: float, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the cosine between tangent and axis, and the turn per length, of the helix under a tension; of its shape.

    In any units of length with EI = 1; 1 and 0 where the rod is straight.
    """
    low = np.zeros_like(tension)
    high = np.ones_like(tension)
    for _ in range(60):  # The left side grows with the cosine.
        middle = (low + high) / 2
        less = ratio * curvature**2 * middle / (1 - (1 - ratio) * middle**2) ** 2 < tension
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    cosine = np.where(tension < curvature**2 / ratio, (low + high) / 2, 1.0)
    return cosine, curvature * np.sqrt(1 - cosine**2) / (1 - (1 - ratio) * cosine**2)


def helix_height(curvature: float, weight: float, ratio: float) -> float:
    """Return the height of a hanging rod of length 1 whose every place is a local helix."""
    at, share = legendre.leggauss(_PLACES)
    return float(local_helix(weight * (at + 1) / 2, curvature, ratio)[0] @ share / 2)
