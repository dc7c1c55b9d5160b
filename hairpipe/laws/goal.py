"""Goal: a damped spring from a point of hair to a place that a body carries.

The force on a point of mass m at x with velocity v, whose goal is g(t), is

    f = m w^2 (g - x) + 2 z m w (g' - v),   w = 2 pi frequency,   z the ratio of damping,

the negative gradient of m w^2 |x - g|^2 / 2 and a damper. It is linear in x and v: in a stage of weight h it is fully
implicit, -h m w^2 - 2 z m w on the diagonal of the banded system, and stable for any step. It costs nothing to speak
of. It is not in Selle, Lentine, Fedkiw 2008.
"""

import numpy as np

from hairpipe.geometry.compile import inlined


def spring_of(masses: np.ndarray, frequency: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness [N/m] and damping [kg/s] for masses [kg], frequencies [Hz] and a ratio of damping; (k,) each."""
    omega = 2.0 * np.pi * frequency
    return masses * omega**2, 2.0 * damping * masses * omega


@inlined
def goal(stiffness, damping, away, slip):
    """Return a component of f [N]; away  of g - x [m]; slip  of g' - v [m/s]."""
    return stiffness * away + damping * slip


@inlined
def goal_slope(stiffness, damping, h):
    """Return how much less f is for a velocity at the end of a stage of weight h [kg/s]."""
    return h * stiffness + damping
