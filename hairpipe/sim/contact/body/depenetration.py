"""Hair inside a body rises out of it slowly, so that the strand is neither stretched nor shaken.

A point that begins a step deeper than DEEP is not held at the surface, which may be out of reach of its root. It is
dragged by a viscous medium that rises by PUSH_OUT along the outward normal n,

    f = m r (w - v),   w = v_b + min(PUSH_OUT, (kept - phi) / dt) n,   r = (STRAIN E A / M) / PUSH_OUT

with E A the axial stiffness of the strand and M its mass: the total force never strains the strand by more than
STRAIN. The push is the gradient of a potential, r PUSH_OUT m times the depth, and motion in the medium is dissipated:
on a body at rest the energy of hair only falls. There is no friction. With a rigid constraint, an overlong strand
stored the work of the push in its springs and was thrown about: at 5 to 14 m/s, throughout the run.

The contact distance of a point is also limited by the point before it, `within_reach`: hair leaves the body from the
root on, and points that the root holds back are not pulled.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.levelset.collider import SdfSample
from hairpipe.sim.contact.body.implicit import DEEP, FREE, INSIDE, PUSH_OUT, ContactState
from hairpipe.sim.contact.scale import USUAL, Scale

STRAIN = 5e-3
"""Largest stretch of a strand by the push on all its points."""
LEAST = 50.0
"""The push is as strong as that, at least [m/s^2]: hair that its weight alone strains by more must come out, too."""
_REACH = 0.8
"""Largest difference in distance of consecutive points, over their segment."""
_CHUNK = 512


def pushes(axial: np.ndarray, masses: np.ndarray, offsets: np.ndarray, scale: Scale = USUAL) -> np.ndarray:
    """Return the acceleration that pushes points [m/s^2], (P,); pure.

    axial    E A of the strands [N], (S,)
    masses   masses of the points [kg], (P,), inf if held
    offsets  offsets of the points of strands, (S+1,) int32
    """
    total = np.add.reduceat(np.where(np.isfinite(masses), masses, 0.0), offsets[:-1])
    push = np.divide(STRAIN * axial, total, out=np.zeros_like(axial), where=total > 0.0)
    return np.repeat(np.maximum(push, LEAST * scale.speed / scale.time), np.diff(offsets))


def within_reach(start_distance: np.ndarray, segments: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the largest contact distances of points in a step, limited by the points before them [m], (P,); pure.

    start_distance  distances from the body at the start of the step [m], (P,)
    segments        lengths from the points to the previous points [m], (P,); arbitrary at roots
    offsets         offsets of the points of strands, (S+1,) int32
    """
    reach = np.roll(start_distance, 1) + _REACH * segments
    reach[offsets[:-1]] = np.inf
    return reach


@njit(cache=True, parallel=True)
def rise(
    contact: ContactState, probe: SdfSample, kept: np.ndarray, push: np.ndarray, mass: np.ndarray, dt: float
) -> None:
    """Mark the points that rise in a step of dt [s], which begin it deep inside, in place; the others become free.

    probe  probe of the body at the points
    kept   contact distance [m], (P,)
    push   [m/s^2], (P,); mass  [kg], (P,), inf: held by the root
    """
    deep, speed = DEEP * contact.length, PUSH_OUT * contact.speed
    for chunk in prange((len(push) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(push))):
            if probe.distance[i] < -deep and mass[i] < np.inf:
                _rise(contact, probe, i, kept[i], push[i] / speed * mass[i], speed, dt)
            elif contact.state[i] == INSIDE:  # Out now: from here on an ordinary contact holds it.
                _release(contact, i)


@inlined
def _release(contact, i):
    contact.discontinuous[i] = True
    contact.state[i] = FREE


@inlined
def _rise(contact, probe, i, kept, damping, fastest, dt):
    nx, ny, nz = probe.normal[i, 0], probe.normal[i, 1], probe.normal[i, 2]
    vx, vy, vz = probe.velocity[i, 0], probe.velocity[i, 1], probe.velocity[i, 2]
    speed = min(fastest, max(kept - probe.distance[i], 0.0) / dt)
    contact.discontinuous[i] |= contact.state[i] != INSIDE
    contact.state[i] = INSIDE
    contact.c_t[i] = contact.c_n[i] = damping  # Isotropic, as in a thick fluid: no surface, and no friction.
    contact.body[i] = vx * nx + vy * ny + vz * nz
    contact.normal[i, 0], contact.normal[i, 1], contact.normal[i, 2] = nx, ny, nz
    contact.target[i, 0], contact.target[i, 1], contact.target[i, 2] = vx + speed * nx, vy + speed * ny, vz + speed * nz
