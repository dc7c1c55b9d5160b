"""Hair against the body: level-set collision after Bridson et al. 2003, step 5 of the paper's nine.

An axis particle that ends a step closer to the surface than its thickness is moved out along the normal n, and its
velocity V relative to the body's Vb loses what points inwards and, by Coulomb friction, part of what slides:

    V_n' = max(V_n, Vb_n),   V_t' = Vb_t + (V_t - Vb_t) max(0, 1 - mu (V_n' - V_n) / |V_t - Vb_t|)

once for the velocity that is kept and once for the displacement of the step. The thickness rises from
the root to the fifth particle, where it stays.

We differ from the paper: perturbed particles follow the mean of their two neighbours on the axis, instead of staying
behind as strain; and a particle that already was inside is pushed out at a bounded speed, so that a groom that starts
within the body does not burst.
"""

import numpy as np
from numba import njit

from hairpipe.levelset.field import Field
from hairpipe.levelset.interpolation import distance_between, evaluate
from hairpipe.sim.models.interface import Shape

_RISE = 5  # particles over which the thickness grows
_PUSH_OUT = 0.5  # [m/s]
_SKIN = 1e-3  # [m]; less than this inside counts as on the surface


@njit(cache=True)
def _slide(ux, uy, uz, nx, ny, nz, push, friction):  # noqa: ANN001, ANN202
    """Relative motion u after a normal push >= 0 and the friction it causes."""
    normal = ux * nx + uy * ny + uz * nz
    tx, ty, tz = ux - normal * nx, uy - normal * ny, uz - normal * nz
    speed = np.sqrt(tx * tx + ty * ty + tz * tz)
    keep = max(0.0, 1.0 - friction * push / speed) if speed > 0.0 else 0.0
    normal += push
    return normal * nx + keep * tx, normal * ny + keep * ty, normal * nz + keep * tz


@njit(cache=True)
def _follow(change: np.ndarray, target: np.ndarray, shape: Shape) -> None:
    """Add changes of axis particles to target, and to the perturbed ones the mean of their neighbours', in place."""
    for p in range(shape.clamped, target.shape[0]):
        for c in range(3):
            for lane in range(target.shape[2]):
                if p % shape.stride:
                    target[p, c, lane] += 0.5 * (change[p - 1, c, lane] + change[p + 1, c, lane])
                else:
                    target[p, c, lane] += change[p, c, lane]


@njit(cache=True)
def collide_body(
    x: np.ndarray,
    v: np.ndarray,
    before: np.ndarray,
    shape: Shape,
    field0: Field,
    field1: Field,
    frame: float,
    times: tuple[float, float],
    scheme: int,
    friction: float,
    thickness: float,
) -> bool:
    """Move a block of strands out of the body at the end of a step, in place; tell whether any touched it.

    x, v            positions [m] and velocities [m/s] at the end of the step, (particles, 3, W)
    before          positions at its start
    field0, field1  the body at the previous and at this frame; frame  time between them [s]
    times           start and end of the step since the previous frame [s]
    scheme          an Interpolation
    """
    dx, dv = np.zeros_like(x), np.zeros_like(v)
    touched = False
    root = shape.clamped - 1
    for p in range(root + shape.stride, x.shape[0], shape.stride):
        kept = thickness * min((p - root) // shape.stride, _RISE) / _RISE
        for lane in range(x.shape[2]):
            px, py, pz = x[p, 0, lane], x[p, 1, lane], x[p, 2, lane]
            if distance_between(scheme, field0, field1, times[1] / frame, frame, px, py, pz) < kept:
                touched = True
                _meet(x, v, before, dx, dv, p, lane, field0, field1, frame, times, scheme, friction, kept)
    if touched:
        _follow(dx, x, shape)
        _follow(dv, v, shape)
    return touched


@njit(cache=True)
def _meet(xs, vs, x0, dx, dv, p, lane, field0, field1, frame, times, scheme, friction, kept):  # noqa: ANN001, ANN202
    """Write what contact changes of one particle's position and velocity to dx and dv."""
    dt = times[1] - times[0]
    px, py, pz = xs[p, 0, lane], xs[p, 1, lane], xs[p, 2, lane]
    qx, qy, qz = x0[p, 0, lane], x0[p, 1, lane], x0[p, 2, lane]
    phi, nx, ny, nz, bx, by, bz = evaluate(scheme, field0, field1, times[1] / frame, frame, px, py, pz)
    start = distance_between(scheme, field0, field1, times[0] / frame, frame, qx, qy, qz)
    depth = (kept if start > -_SKIN else min(kept, start + _PUSH_OUT * dt)) - phi
    ux, uy, uz = px - qx - dt * bx, py - qy - dt * by, pz - qz - dt * bz
    sx, sy, sz = _slide(ux, uy, uz, nx, ny, nz, max(depth, 0.0), friction)
    dx[p, 0, lane], dx[p, 1, lane], dx[p, 2, lane] = sx - ux, sy - uy, sz - uz
    ux, uy, uz = vs[p, 0, lane] - bx, vs[p, 1, lane] - by, vs[p, 2, lane] - bz
    push = max(0.0, -(ux * nx + uy * ny + uz * nz))
    sx, sy, sz = _slide(ux, uy, uz, nx, ny, nz, push, friction)
    dv[p, 0, lane], dv[p, 1, lane], dv[p, 2, lane] = sx - ux, sy - uy, sz - uz
