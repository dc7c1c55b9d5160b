"""Level ground at y = 0, with friction.

A particle on the ground is held there by the solve, which gives the force N that the ground carries it with; where the
ground would have to pull, it is released. Coulomb friction is part of the solve as a drag mu N / |v| on the tangential
velocity, with N and |v| of the step before and |v| at least CREEP, so what rests creeps at most so fast. What is below
the ground after a step is put on it and loses its downward velocity; the impulse of that, spread over a step, is its N.
"""

import math

import numpy as np
from numba import njit

CREEP = 1e-3
"""[m/s]"""


@njit(cache=True)
def hold(free: np.ndarray, moves: np.ndarray, pressed: np.ndarray) -> None:
    """Set which unknowns are free (n, 3), in place: not the height of what is pressed on the ground."""
    for i in range(len(free)):
        for c in range(3):
            free[i, c] = moves[i, c]
        if pressed[i] > 0.0:
            free[i, 1] = 0.0


@njit(cache=True)
def drag_of(v: np.ndarray, pressed: np.ndarray, friction: float, drag: np.ndarray) -> None:
    """Set the tangential drag of what is on the ground [kg/s], (n,), in place."""
    for i in range(len(v)):
        speed = math.sqrt(v[i, 0] ** 2 + v[i, 2] ** 2)
        drag[i] = friction * pressed[i] / max(speed, CREEP)


@njit(cache=True)
def land(
    x: np.ndarray, v: np.ndarray, pressed: np.ndarray, reaction: np.ndarray, mass: np.ndarray, h: float, dt: float
) -> None:
    """Put what fell through on the ground and release points that would have to be pulled, in place.

    x, v      positions [m] and velocities [m/s], (n, 3)
    pressed   force of the ground [N], (n,)
    reaction  impulse that held an unknown in the last stage [N s], (n, 3)
    h, dt     weight of that stage's end, and the step that it is of, for which friction will act [s]
    """
    for i in range(len(x)):
        if pressed[i] > 0.0:
            pressed[i] = max(reaction[i, 1] / h, 0.0)
        if x[i, 1] < 0.0 or (x[i, 1] == 0.0 and v[i, 1] < 0.0):
            pressed[i] = max(pressed[i], -mass[i] * v[i, 1] / dt)
            x[i, 1] = 0.0
            v[i, 1] = max(v[i, 1], 0.0)
