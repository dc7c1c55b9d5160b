"""Static Kirchhoff rods: inextensible, bent and twisted in space, curly by nature, under weight and end loads.

Along the arc s, with the frame R (columns d1, d2, d3; d3 is the tangent) of the material:

    r' = d3,   R' = R [u]x,   n' = -weight,   m' = -d3 x n
    m = EI (u1 - u1^) d1 + EI (u2 - u2^) d2 + GJ (u3 - u3^) d3

(Love, Mathematical Theory of Elasticity, 253 to 260; Antman, Nonlinear Problems of Elasticity, VIII). n and m are what
the part beyond s does to the part before it. R is a quaternion q here. As the section is round,

    2 q' = m/EI q + q (u^ + (1/GJ - 1/EI) (m . d3) e3)
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from hairpipe.graphs.experiments.studies.theory.rod_frames import frames_of, left, right, tangent_slopes, tangents

POINT, TURN, FORCE, COUPLE = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
"""Rows of the unknowns, in units of the length L and of EI."""
_MOST_NODES = 10_000
_E3 = right(np.array([0.0, 0.0, 0.0, 1.0]))
_BASIS = [left(unit) for unit in np.eye(4)[1:]]


@dataclass(frozen=True, eq=False)
class Rod:
    """A round rod.

    length   [m]
    bending  EI [N m^2]
    torsion  GJ [N m^2]
    natural  curvatures u1^, u2^ and twist u3^ without load, at the start [1/m], (3,)
    weight   force per length [N/m], (3,)
    growth   of `natural` along the arc [1/m^2], (3,)
    """

    length: float
    bending: float
    torsion: float
    natural: np.ndarray
    weight: np.ndarray
    growth: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def natural_at(self, arc: np.ndarray) -> np.ndarray:
        """Return `natural` at places along the arc [m], (n,): [1/m], (3, n)."""
        return self.natural[:, None] + self.growth[:, None] * arc


@dataclass(frozen=True, eq=False)
class Shape:
    """A rod in equilibrium.

    arc          where it is known [m], (n,)
    points       [m], (n, 3)
    quaternions  of the frames, (n, 4)
    force        n [N], (n, 3)
    couple       m [N m], (n, 3)
    """

    arc: np.ndarray
    points: np.ndarray
    quaternions: np.ndarray
    force: np.ndarray
    couple: np.ndarray

    @property
    def frames(self) -> np.ndarray:
        """Directors d1, d2, d3 as columns, (n, 3, 3)."""
        return frames_of(self.quaternions.T)


def balance(rod: Rod, ends: Callable[[np.ndarray, np.ndarray], np.ndarray], guess: Shape, tolerance: float) -> Shape:
    """Solve for the equilibrium near a guess.

    ends       13 residuals from the unknowns at the start and at the end, (13,) each
    tolerance  of the relative residual of the equations

    ArithmeticError where none is found. Pure.
    """
    from scipy.integrate import solve_bvp

    length = rod.length
    unit = rod.bending / rod.length
    load = rod.weight * length**2 / unit
    ratio = rod.bending / rod.torsion - 1
    scales = np.repeat([length, 1.0, unit / length, unit], [3, 4, 3, 3])[:, None]

    def turning(s: np.ndarray) -> np.ndarray:
        """q -> q u^, (4, 4, n)."""
        return right(np.stack([0 * s, *(length * rod.natural_at(length * s))]))

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        q, m = y[TURN], y[COUPLE]
        tangent = tangents(q)
        twist = ratio * np.sum(m * tangent, axis=0)
        body = np.einsum("ijn,jn->in", turning(s), q) + twist * (_E3 @ q)
        world = np.einsum("ijn,jn->in", left(np.stack([0 * s, *m])), q)
        pull = np.cross(y[FORCE], tangent, axis=0)
        return np.concatenate([tangent, (body + world) / 2, np.repeat(-load[:, None], len(s), 1), pull])

    def jacobian(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        q, n, m = y[TURN], y[FORCE], y[COUPLE]
        tangent = tangents(q)
        turned = tangent_slopes(q)
        twist = ratio * np.sum(m * tangent, axis=0)
        along = ratio * (_E3 @ q)
        matrix = np.zeros((13, 13, len(s)))
        matrix[POINT, TURN] = turned
        spin = turning(s) + twist * _E3[:, :, None] + left(np.stack([0 * s, *m]))
        matrix[TURN, TURN] = (spin + along[:, None] * np.einsum("in,ijn->jn", m, turned)) / 2
        matrix[TURN, COUPLE] = (along[:, None] * tangent + np.stack([unit @ q for unit in _BASIS], axis=1)) / 2
        matrix[COUPLE, TURN] = np.cross(n[:, None], turned, axis=0)
        matrix[COUPLE, FORCE] = -np.cross(tangent[:, None], np.eye(3)[:, :, None], axis=0)
        return matrix

    state = np.concatenate([guess.points.T, guess.quaternions.T, guess.force.T, guess.couple.T]) / scales
    arc = guess.arc / length
    with np.errstate(all="ignore"):  # where the guess is too far off the iterates overflow, and we say so
        found = solve_bvp(slope, ends, arc, state, fun_jac=jacobian, tol=tolerance, max_nodes=_MOST_NODES)
    if not (found.success and np.isfinite(found.y).all()):
        raise ArithmeticError(f"no equilibrium of the rod: {found.message}")
    points, quaternions, force, couple = (part.T for part in np.split(found.y * scales, [3, 7, 10]))
    return Shape(found.x * length, points, quaternions, force, couple)
