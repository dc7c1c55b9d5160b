"""Contact with the body inside the solve: normals are held, friction acts, and only what pushes stays.

A point that would end a stage nearer to the body than its thickness d is held along the normal n at the velocity that
takes it there, w_n = v_n + (d - phi) / h, by a damper so stiff that nothing else counts, in the strand's own system:

    f = c_n n n^T (w - v) + c_t (I - n n^T) (w - v),   c_n = STIFF m / h

Tangentially it sticks, c_t = c_n and w_t the body's velocity, until the force that takes exceeds Coulomb's limit; then
it slides, c_t = 0, under that limit against its motion. It sticks again when it would turn round, and is let go of when
the body would have to pull. What has changed is solved again, from where the solve before ended.

We differ from the paper, which moves positions first and holds the normals of what it moved in the velocity solve
(equality, for a whole step): here nothing is stretched by being pushed, and friction and tension see each other, so
that a hair around a post holds as Euler and Eytelwein say.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.levelset.moving import Probe

FREE, STICKS, SLIDES = 0, 1, 2
STIFF = 1e4  # a hair that is pulled onto the body with 1 mN sinks in by less than 5 um in a step of 1/240 s
_NEAR = 1e-5  # [m]; what touches is held up to this far outside, and what is free is caught from this far inside
_TURNED = 0.9  # cosine between normals; what turns farther in a step is a shock
_PUSH_OUT = 0.5  # [m/s]; for points that begin deeper than _DEEP
_DEEP = 1e-3  # [m]
_CHUNK = 512


class Touch(NamedTuple):
    """How points touch the body; arrays that a stage changes in place.

    state     FREE, STICKS or SLIDES, (P,) int8
    force     that friction has on a point that slides, over its normal force: unit, (P, 3)
    load      normal force in the last solve [N], (P,)
    applied   friction of points that slide, as the solve had it [N], (P,)
    freed     let go of in this stage, (P,) bool
    shocked   began or ceased to touch in this step, or were turned about: forces jumped, (P,) bool
    normal    (P, 3); rate  c_n, (P,) [kg/s]; target  w [m/s], (P, 3)
    body      speed of the body along the normal [m/s], (P,)
    """

    state: np.ndarray
    force: np.ndarray
    load: np.ndarray
    applied: np.ndarray
    freed: np.ndarray
    shocked: np.ndarray
    normal: np.ndarray
    rate: np.ndarray
    target: np.ndarray
    body: np.ndarray

    @classmethod
    def none(cls, count: int) -> "Touch":
        """Make points that touch nothing."""
        vectors, numbers = [np.zeros((count, 3)) for _ in range(3)], [np.zeros(count) for _ in range(4)]
        state, freed, shocked = np.zeros(count, np.int8), np.zeros(count, np.bool_), np.zeros(count, np.bool_)
        return cls(
            state, vectors[0], numbers[0], numbers[1], freed, shocked, vectors[1], numbers[2], vectors[2], numbers[3]
        )


@njit(cache=True, parallel=True)
def hold(touch: Touch, probe: Probe, x, v, begun, thickness, mass, friction, h, who, push, damping) -> None:  # noqa: ANN001
    """Hold the points that touch: add their forces, push - damping v, in place.

    probe      of the body at x
    x, v       where the stage is linearised [m], [m/s], (P, 3)
    begun      distance at the start of the step [m], (P,)
    thickness  [m], (P,); mass [kg], (P,); inf: held by the root
    h          weight of the stage's end [s]
    who        points that are solved now, (P,) bool; the others are held as before
    push       [N], (P, 3); damping [kg/s], (P, 6)
    """
    for chunk in prange((len(x) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(x))):
            if who[i]:
                _aim(touch, probe, i, v, begun[i], thickness[i], mass[i], h)
            if touch.state[i] != FREE:
                if who[i]:
                    touch.applied[i] = friction * touch.load[i]
                _add_hold(touch, i, push, damping)


@njit(cache=True)
def _aim(touch, probe, i, v, begun, thickness, mass, h):  # noqa: ANN001, ANN202
    """Decide whether point i touches, and where it is to go."""
    phi = probe.distance[i]
    near = _NEAR if touch.state[i] != FREE else (-_NEAR if touch.freed[i] else 0.0)
    nx, ny, nz = probe.normal[i, 0], probe.normal[i, 1], probe.normal[i, 2]
    if not (phi < thickness + near and mass < np.inf and nx * nx + ny * ny + nz * nz > 0.5):
        touch.shocked[i] |= touch.state[i] != FREE
        touch.state[i] = FREE
        touch.load[i] = 0.0
        return
    old = touch.normal[i]
    touch.shocked[i] |= touch.state[i] == FREE or old[0] * nx + old[1] * ny + old[2] * nz < _TURNED
    if touch.state[i] == FREE:
        touch.state[i] = STICKS
    bx, by, bz = probe.velocity[i, 0], probe.velocity[i, 1], probe.velocity[i, 2]
    body = bx * nx + by * ny + bz * nz
    wanted = v[i, 0] * nx + v[i, 1] * ny + v[i, 2] * nz + (thickness - phi) / h
    if begun < -_DEEP:
        wanted = min(wanted, body + _PUSH_OUT)
    extra = wanted - body
    touch.rate[i] = STIFF * mass / h
    touch.body[i] = body
    touch.normal[i, 0], touch.normal[i, 1], touch.normal[i, 2] = nx, ny, nz
    touch.target[i, 0], touch.target[i, 1], touch.target[i, 2] = bx + extra * nx, by + extra * ny, bz + extra * nz


@njit(cache=True)
def _add_hold(touch, i, push, damping):  # noqa: ANN001, ANN202
    c, n, w = touch.rate[i], touch.normal[i], touch.target[i]
    if touch.state[i] == STICKS:
        for a in range(3):
            push[i, a] += c * w[a]
        damping[i, 0] += c
        damping[i, 3] += c
        damping[i, 5] += c
        return
    wanted = c * (w[0] * n[0] + w[1] * n[1] + w[2] * n[2])
    for a in range(3):
        push[i, a] += wanted * n[a] + touch.applied[i] * touch.force[i, a]
    damping[i, 0] += c * n[0] * n[0]
    damping[i, 1] += c * n[0] * n[1]
    damping[i, 2] += c * n[0] * n[2]
    damping[i, 3] += c * n[1] * n[1]
    damping[i, 4] += c * n[1] * n[2]
    damping[i, 5] += c * n[2] * n[2]


@njit(cache=True, parallel=True)
def judge(touch: Touch, probe: Probe, v, thickness, mass, friction, who, changed) -> None:  # noqa: ANN001
    """Look at what a solve found: set changed, (P,) bool, where points must be solved again, in place.

    probe  of the body where points are now; v  their velocities [m/s], (P, 3); the others as for `hold`
    """
    for chunk in prange((len(v) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(v))):
            changed[i] = False
            if who[i] and mass[i] < np.inf:
                if touch.state[i] == FREE:
                    phi = probe.distance[i]
                    moved = probe.normal[i, 0] != 0.0 or probe.normal[i, 1] != 0.0 or probe.normal[i, 2] != 0.0
                    changed[i] = moved and phi < thickness[i] - (2 * _NEAR if touch.freed[i] else _NEAR)
                else:
                    changed[i] = _judge_touch(touch, i, v, friction)


@njit(cache=True)
def _judge_touch(touch, i, v, friction):  # noqa: ANN001, ANN202
    """Change the state of point i if it must change; tell whether it did."""
    c, n, w = touch.rate[i], touch.normal[i], touch.target[i]
    ux, uy, uz = v[i, 0] - w[0], v[i, 1] - w[1], v[i, 2] - w[2]
    normal = ux * n[0] + uy * n[1] + uz * n[2]
    pressed = -c * normal
    if pressed < 0.0:
        touch.state[i] = FREE
        touch.freed[i] = touch.shocked[i] = True
        touch.load[i] = 0.0
        return True
    tx, ty, tz = ux - normal * n[0], uy - normal * n[1], uz - normal * n[2]
    speed = np.sqrt(tx * tx + ty * ty + tz * tz)
    before, touch.load[i] = touch.load[i], pressed
    if touch.state[i] == STICKS:
        if c * speed <= friction * pressed:
            return False
        touch.state[i] = SLIDES
    else:
        f = touch.force[i]
        if tx * f[0] + ty * f[1] + tz * f[2] > 0.0:
            touch.state[i] = STICKS
            return True
    if speed > 0.0:
        touch.force[i, 0], touch.force[i, 1], touch.force[i, 2] = -tx / speed, -ty / speed, -tz / speed
    return abs(touch.load[i] - before) > 0.2 * max(before, touch.load[i]) and friction > 0.0


@njit(cache=True, parallel=True)
def stop_normals(touch: Touch, v, change) -> None:  # noqa: ANN001
    """Set change, (P, 3), to what takes from v the speed that only put points in their place [m/s], in place.

    A contact gives nothing back.

    v  [m/s], (P, 3)
    """
    for chunk in prange((len(v) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(v))):
            change[i] = 0.0
            if touch.state[i] != FREE:
                n = touch.normal[i]
                excess = v[i, 0] * n[0] + v[i, 1] * n[1] + v[i, 2] * n[2] - touch.body[i]
                for a in range(3):
                    change[i, a] = -excess * n[a]
