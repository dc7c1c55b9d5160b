"""One linearly implicit stage of a mesh: assemble and solve once, as `solve/implicit_stage.py` does for strands.

(M + h D + h^2 K) dv = M (vh - v) + h (f(x) - D v),   v += dv,  x += h dv,   x = xh + h v
"""

import warnings
from dataclasses import dataclass

import numpy as np

from hairpipe.graphs.experiments.elastic.block_pcg import solve
from hairpipe.graphs.experiments.elastic.ground import drag_of, hold
from hairpipe.graphs.experiments.elastic.spring_assembly import add_altitudes, add_linear, find_tensions
from hairpipe.graphs.experiments.elastic.spring_mesh import Springs

TOLERANCE = 1e-6
"""Of the residual. Block Jacobi needs 50 to 200 iterations for it and beats a sparse LU tenfold at 4,000 unknowns."""
MOST = 2000


@dataclass
class Body:
    """A body of springs while it is advanced; what moves is changed in place.

    springs   of it
    x, v, a   positions [m], velocities [m/s] and accelerations [m/s^2], (n, 3)
    T         multipliers of the linear springs [N], (e,)
    pressed   force of the ground on every particle, 0 where they do not touch [N], (n,)
    damping   time over which stiffness damps [s]
    air       drag of still air [1/s]
    gravity   along -Y [m/s^2]
    friction  of the ground, None where there is none
    """

    springs: Springs
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    T: np.ndarray
    pressed: np.ndarray
    damping: float
    air: float
    gravity: float
    friction: float | None


def run_stage(body: Body, xh: np.ndarray, vh: np.ndarray, guess: np.ndarray, h: float) -> np.ndarray:
    """Advance a body through a stage, in place, and give the impulses that held it [N s], (n, 3).

    xh, vh  explicit parts of position and velocity, (n, 3)
    guess   of the velocity at the end [m/s], (n, 3)
    h       weight of the end [s]
    """
    springs = body.springs
    mass = body.springs.mass
    free = np.empty_like(xh)
    drag = np.zeros(len(xh))
    hold(free, springs.free, body.pressed)
    if body.friction is not None:
        drag_of(guess, body.pressed, body.friction, drag)
    v = np.where(free > 0, guess, 0.0)
    grounded = body.pressed > 0
    v[grounded, 1] = -xh[grounded, 1] / h
    x = xh + h * v
    A = np.zeros((len(springs.pattern.column), 3, 3))
    weight = np.repeat((mass * (1 + h * body.air))[:, None], 3, axis=1)
    weight[:, [0, 2]] += h * drag[:, None]
    A[springs.pattern.diagonal] = weight[:, :, None] * np.eye(3)
    b = mass[:, None] * (vh - h * body.gravity * np.array([0.0, 1.0, 0.0])) - weight * v
    if springs.pulls.any():
        add_linear(A, b, x, v, body.T, springs, h, body.damping)
        add_altitudes(A, b, x, v, springs, h, body.damping)
    dv, held, made = solve(A, b, springs.pattern, free, TOLERANCE, MOST)
    if made == MOST:
        warnings.warn(f"a solve did not converge in {MOST} iterations", stacklevel=2)
    find_tensions(body.T, x, h * dv, springs)
    body.x = x + h * dv
    body.v = v + dv
    return held
