"""Steps of a body of springs in time, as sequences of stages: TR-BDF2 and backward Euler, see `sim/integrators/`."""

from collections.abc import Callable

import numpy as np

from hairpipe.graphs.experiments.elastic.elastic_settings import Scheme
from hairpipe.graphs.experiments.elastic.elastic_stage import Body, run_stage
from hairpipe.graphs.experiments.elastic.ground import land

G = 2 - np.sqrt(2.0)
"""Where the first stage of TR-BDF2 ends, in steps."""


def backward_euler(body: Body, dt: float) -> None:
    """Advance a body by a step [s], in place: one stage, of first order."""
    before = body.v
    held = run_stage(body, body.x, body.v, body.v, dt)
    body.a = (body.v - before) / dt
    _land(body, held, dt, dt)


def tr_bdf2(body: Body, dt: float) -> None:
    """Advance a body by a step [s], in place: a trapezoidal stage and one of BDF2, of second order."""
    x = body.x
    v = body.v
    h = G * dt / 2
    run_stage(body, x + h * v, v + h * body.a, v, h)
    w1 = 1 / (G * (2 - G))
    w0 = (1 - G) ** 2 / (G * (2 - G))
    xh, vh = w1 * body.x - w0 * x, w1 * body.v - w0 * v
    held = run_stage(body, xh, vh, body.v, h)
    body.a = (body.v - vh) / h
    _land(body, held, h, dt)


def _land(body: Body, held: np.ndarray, h: float, dt: float) -> None:
    if body.friction is not None:
        land(body.x, body.v, body.pressed, held, body.springs.mass, h, dt)


SCHEMES: dict[Scheme, Callable[[Body, float], None]] = {"tr_bdf2": tr_bdf2, "backward_euler": backward_euler}
