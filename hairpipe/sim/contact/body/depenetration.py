"""Hair inside a body rises out of it: gently, so that what holds it there is neither stretched nor shaken.

A point that begins a step deeper than DEEP is not held where the surface is, which its root may never let it reach. It
goes through something thick that rises by PUSH_OUT along the way out n,

    f = m r (w - v),   w = v_b + min(PUSH_OUT, (kept - phi) / dt) n,   r = (STRAIN E A / M) / PUSH_OUT

with E A the stiffness of the strand along itself and M its mass: all of it together never strains the strand by more
than STRAIN. The push is the slope of a potential, r PUSH_OUT m times the depth, and the path of the point across it is
lost: on a body that stands still the energy of hair only falls. Friction there is none. Held hard, a strand longer than
it may be stored the work of the push in its springs, and was thrown about by it: at 5 to 14 m/s, for as long as it ran.

Nor does any point keep more from the body than the one before it lets it, `within_reach`: hair is drawn out from the
root on, and what the root holds back is not pulled at.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.levelset.collider import SdfSample
from hairpipe.sim.contact.body.implicit import DEEP, FREE, INSIDE, PUSH_OUT, ContactState

STRAIN = 5e-3
"""Of a strand that the push on all its points would stretch at most."""
LEAST = 50.0
"""The push is as strong as that, at least [m/s^2]: hair that its weight alone strains by more must come out, too."""
_REACH = 0.8
"""Of a segment, that a point gets farther out than the one before it: no more would be straight up."""
_CHUNK = 512


def pushes(axial: np.ndarray, masses: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return how strongly points are pushed [m/s^2], (P,); pure.

    axial    E A of the strands [N], (S,)
    masses   of the points [kg], (P,), inf where held
    offsets  of the points of strands, (S+1,) int32
    """
    total = np.add.reduceat(np.where(np.isfinite(masses), masses, 0.0), offsets[:-1])
    push = np.divide(STRAIN * axial, total, out=np.zeros_like(axial), where=total > 0.0)
    return np.repeat(np.maximum(push, LEAST), np.diff(offsets))


def within_reach(start_distance: np.ndarray, segments: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return how far from the body points may be kept in a step, where the ones before them began it [m], (P,); pure.

    start_distance  distances from the body there [m], (P,)
    segments        from the points to those before them [m], (P,); of roots anything
    offsets         of the points of strands, (S+1,) int32
    """
    reach = np.roll(start_distance, 1) + _REACH * segments
    reach[offsets[:-1]] = np.inf
    return reach


@njit(cache=True, parallel=True)
def rise(
    contact: ContactState, probe: SdfSample, kept: np.ndarray, push: np.ndarray, mass: np.ndarray, dt: float
) -> None:
    """Let points rise in a step of dt [s] that begin it deep inside, in place; those that do not any more are free.

    probe  of the body there
    kept   from it [m], (P,)
    push   [m/s^2], (P,); mass  [kg], (P,), inf: held by the root
    """
    for chunk in prange((len(push) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(push))):
            if probe.distance[i] < -DEEP and mass[i] < np.inf:
                _rise(contact, probe, i, kept[i], push[i] / PUSH_OUT * mass[i], dt)
            elif contact.state[i] == INSIDE:  # Out now: from here on an ordinary contact holds it.
                _release(contact, i)


@inlined
def _release(contact, i):
    contact.discontinuous[i] = True
    contact.state[i] = FREE


@inlined
def _rise(contact, probe, i, kept, damping, dt):
    nx, ny, nz = probe.normal[i, 0], probe.normal[i, 1], probe.normal[i, 2]
    vx, vy, vz = probe.velocity[i, 0], probe.velocity[i, 1], probe.velocity[i, 2]
    speed = min(PUSH_OUT, max(kept - probe.distance[i], 0.0) / dt)
    contact.discontinuous[i] |= contact.state[i] != INSIDE
    contact.state[i] = INSIDE
    contact.c_t[i] = contact.c_n[i] = damping  # Isotropic, as in a thick fluid: no surface, and no friction.
    contact.body[i] = vx * nx + vy * ny + vz * nz
    contact.normal[i, 0], contact.normal[i, 1], contact.normal[i, 2] = nx, ny, nz
    contact.target[i, 0], contact.target[i, 1], contact.target[i, 2] = vx + speed * nx, vy + speed * ny, vz + speed * nz
