"""The heavy elastica: a clamped rod that bends in a plane under its own weight, however far.

In units of the length L and of EI / L, with the angle a above the horizontal and Gamma = rho A g L^3 / (EI):

    a'' = Gamma (1 - s) cos a,   a(0) = clamp,  a'(1) = 0,   x' = cos a,  y' = sin a

(moment balance m' = -r' x n of a rod that carries n = -Gamma (1 - s) e_y; Wang, "A critical review of the heavy
elastica", Int. J. Mech. Sci. 28, 1986). For large Gamma the rod hangs but for a layer of Gamma^(-1/2) at the clamp.
"""

from dataclasses import dataclass

import numpy as np

_FACTOR = 1.25
"""From one Gamma of the continuation to the next."""
_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Elastica:
    """A bent rod of length 1.

    arc     where it is known, (n,)
    angle   above the horizontal [rad], (n,)
    moment  in units of EI / L, (n,)
    points  horizontal and upward, (n, 2)
    """

    arc: np.ndarray
    angle: np.ndarray
    moment: np.ndarray
    points: np.ndarray

    @property
    def tip(self) -> np.ndarray:
        """Its free end, (2,)."""
        return self.points[-1]


def bend_elastica(gamma: float, clamp: float = 0.0) -> Elastica:
    """Find the shape that a straight rod reaches as its weight grows from nothing.

    gamma  rho A g L^3 / (E I)
    clamp  inclination of the clamp above the horizontal [rad]: pi/2 stands upright, -pi/2 hangs

    Upright, beyond gamma = 7.8373, this is a shape that is not stable. ArithmeticError where the continuation loses its
    way: within a degree of upright.
    """
    from scipy.integrate import solve_bvp

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.stack([y[1], load * (1 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def jacobian(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        matrix = np.zeros((4, 4, len(s)))
        matrix[0, 1] = 1
        matrix[1, 0] = -load * (1 - s) * np.sin(y[0])
        matrix[2, 0], matrix[3, 0] = -np.sin(y[0]), np.cos(y[0])
        return matrix

    def ends(start: np.ndarray, end: np.ndarray) -> np.ndarray:
        return np.array([start[0] - clamp, end[1], start[2], start[3]])

    arc = np.linspace(0, 1, 21) ** 2
    state = np.stack([np.full_like(arc, clamp), 0 * arc, arc * np.cos(clamp), arc * np.sin(clamp)])
    steps = int(np.ceil(np.log(max(gamma, 1)) / np.log(_FACTOR)))
    for load in gamma / _FACTOR ** np.arange(steps, -1, -1):
        last = load == gamma
        found = solve_bvp(slope, ends, arc, state, fun_jac=jacobian, tol=_TOLERANCE if last else 1e-4, max_nodes=50_000)
        if not found.success or found.y[1].max() > 1e-3:  # other solutions wave; this one bends downward all along
            raise ArithmeticError(f"no elastica for gamma = {load:g}: {found.message}")
        arc, state = found.x, found.y
    return Elastica(arc, state[0], state[1], state[2:].T)
