"""Hair out of the body at the end of a step: level-set collision after Bridson et al. 2003, step 5 of the paper's nine.

A point that ends a step nearer to the surface than its thickness is moved out along the normal n. Its velocity V, V_b
being the body's, loses its inward component and, by Coulomb friction, part of its tangential component:

    V_n' = max(V_n, Vb_n),   V_t' = Vb_t + (V_t - Vb_t) max(0, 1 - mu (V_n' - V_n) / |V_t - Vb_t|)

once for the final velocity and once for the displacement of the step. A point that passed through the body, or would
be pushed out on the other side, continues from its first contact with V'; a point that leaves on the same side has
slid around the body, and only its straight path cuts through.

We differ from the paper: points that begin inside are left to `body.py`, and points that begin nearer than
their thickness are moved out at a bounded speed, so that a groom that starts within the body does not burst; no
segment is stretched by more than a tenth (`drape`), so that squeezed hair is not flung away when it is
released; and where contact is held in the solve (`body_implicit.py`), only its remaining errors are corrected.

Projection of strands out of a body without stretch: alternates between both constraints.

A point that was moved out may be too far from its neighbour towards the root. It is pulled towards that neighbour in
the plane of its contact, so that it slides along the body and not back into it; on a curved body it is then moved out
again. If that fails, as when a thin part of the body separates the two, it is placed next to the neighbour, on the
same side of the body. The neighbour is outside, so a valid place always exists.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.contact.body_implicit import DEEP, PUSH_OUT
from hairpipe.contact.contact_points import USUAL, Scale
from hairpipe.geometry.collider import SdfSample
from hairpipe.laws.coulomb import slide
from hairpipe.solve.stretch import STRETCH

_CHUNK = 512


class Motion(NamedTuple):
    """Points in a step, and the law that corrects them.

    before, after  positions [m], (P, 3)
    speeds         velocities [m/s], (P, 3)
    most           largest distance from the body to which points are moved out [m], (P,); -inf: unchanged
    thickness      [m], (P,); mass [kg], inf if held, (P,)
    dt             the step [s]
    friction       Coulomb coefficient
    """

    before: np.ndarray
    after: np.ndarray
    speeds: np.ndarray
    most: np.ndarray
    thickness: np.ndarray
    mass: np.ndarray
    dt: float
    friction: float


def farthest(start_distance: np.ndarray, dt: float, scale: Scale = USUAL) -> np.ndarray:
    """Return the distances [m] up to which points that began a step of dt [s] at others are moved out, (P,); pure."""
    deep, speed = DEEP * scale.length, PUSH_OUT * scale.speed
    return np.where(start_distance < -deep, -np.inf, start_distance + speed * dt)


@njit(cache=True, parallel=True)
def project(
    motion: Motion,
    ended: SdfSample,
    met: np.ndarray,
    shares: np.ndarray,
    meeting: SdfSample,
    leaving: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find the corrections of positions [m] and velocities [m/s], (P, 3); pure.

    ended    probe of the body at the points at the end of the step
    met      points that ran into it, ascending; shares  fractions of the step just before contact
    meeting  probe of the body at these contacts
    leaving  normals of the body at their final positions, zero far from it, (len(met), 3)

    Also returns the points that touched, (P,) bool, and their normals, (P, 3).
    """
    count = len(motion.after)
    dx = np.zeros((count, 3))
    dv = np.zeros((count, 3))
    touched = np.zeros(count, np.bool_)
    normals = np.zeros((count, 3))
    for chunk in prange((count + _CHUNK - 1) // _CHUNK):
        next_met = np.searchsorted(met, chunk * _CHUNK)
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, count)):
            through = -1
            if next_met < len(met) and met[next_met] == i:  # Both ascend: one walk over points finds what each has met.
                through = next_met
                next_met = next_met + 1
            kept, phi = motion.thickness[i], ended.distance[i]
            n = (ended.normal[i, 0], ended.normal[i, 1], ended.normal[i, 2])
            out = n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0.5
            if through >= 0:
                m = (meeting.normal[through, 0], meeting.normal[through, 1], meeting.normal[through, 2])
                end = leaving[through]
                same = m[0] * end[0] + m[1] * end[1] + m[2] * end[2]
                # Opposite normals: it came out on the other side, and has to go on from where it met the body.
                if same <= 0.0 and m[0] * m[0] + m[1] * m[1] + m[2] * m[2] > 0.5:
                    b = (meeting.velocity[through, 0], meeting.velocity[through, 1], meeting.velocity[through, 2])
                    _stop(motion, i, shares[through], m, b, dx, dv)
                    touched[i] = True
                    normals[i, 0], normals[i, 1], normals[i, 2] = m
                    continue
            if phi < kept and out and motion.mass[i] < np.inf and motion.most[i] > -np.inf:
                b = (ended.velocity[i, 0], ended.velocity[i, 1], ended.velocity[i, 2])
                _meet(motion, i, n, b, max(min(kept, motion.most[i]) - phi, 0.0), dx, dv)
                touched[i] = True
                normals[i, 0], normals[i, 1], normals[i, 2] = n
    return dx, dv, touched, normals


@njit(cache=True)
def _slow(motion, i, n, b, dv):
    """Remove the inward component of the velocity, with its friction."""
    v = motion.speeds[i]
    u = (v[0] - b[0], v[1] - b[1], v[2] - b[2])
    s = slide(u, n, max(0.0, -(u[0] * n[0] + u[1] * n[1] + u[2] * n[2])), motion.friction)
    dv[i, 0], dv[i, 1], dv[i, 2] = s[0] - u[0], s[1] - u[1], s[2] - u[2]


@njit(cache=True)
def _meet(motion, i, n, b, push, dx, dv):
    """Move a point that is too near out, friction acting on what it moved in the step."""
    p = motion.after[i]
    q = motion.before[i]
    dt = motion.dt
    u = (p[0] - q[0] - dt * b[0], p[1] - q[1] - dt * b[1], p[2] - q[2] - dt * b[2])
    s = slide(u, n, push, motion.friction)
    dx[i, 0], dx[i, 1], dx[i, 2] = s[0] - u[0], s[1] - u[1], s[2] - u[2]
    _slow(motion, i, n, b, dv)


@njit(cache=True)
def _stop(motion, i, share, n, b, dx, dv):
    """Move a point that went through along the surface from the place of the hit."""
    p = motion.after[i]
    q = motion.before[i]
    dt = motion.dt
    w = ((p[0] - q[0]) / dt - b[0], (p[1] - q[1]) / dt - b[1], (p[2] - q[2]) / dt - b[2])
    s = slide(w, n, max(0.0, -(w[0] * n[0] + w[1] * n[1] + w[2] * n[2])), motion.friction)
    for a in range(3):
        dx[i, a] = (1.0 - share) * dt * (s[a] - w[a])  # The way to the body was free; only the rest of the step slides.
    _slow(motion, i, n, b, dv)


_ROUNDS = 64  # of both; what is inside then cannot be helped
_PATIENCE = 4  # rounds until points are laid next to those before them
_SHORT = 0.5  # of what a point keeps from the body; nearer than that it is moved out again
_SHORTEST = 1e-4  # [m]; nothing that is nearer by less than this is moved again
_STEEPEST = 0.9  # of the longest way to a neighbour, that may be along the normal


def drape(
    after: np.ndarray,
    dx: np.ndarray,
    normals: np.ndarray,
    most: np.ndarray,
    masses: np.ndarray,
    look: Callable[[np.ndarray, np.ndarray], tuple[SdfSample, np.ndarray]],
    scale: float = 1.0,
) -> None:
    """Change dx, (P, 3) [m], in place, until it neither stretches a segment nor leaves a point inside.

    after    positions without dx, which moves them out [m], (P, 3)
    normals  directions of these motions, 0 for points not moved, (P, 3); in place
    most     largest distance from the body to which points are moved out [m], (P,)
    masses   [kg], (P,); inf if held, at roots
    look     finds the probe of the body at positions [m], (n, 3), of points (n,), and their contact distances [m],
             (n,)
    scale    of lengths [1], see `Scale`
    """
    moved = after + dx
    strands = np.cumsum(np.isinf(masses))
    wrong = np.ones(strands[-1] + 1, bool)
    for turn in range(_ROUNDS):
        keep_lengths(after, normals, masses, moved)
        looked = np.flatnonzero(wrong[strands])
        chosen = looked[(moved[looked] != after[looked]).any(axis=1)]
        probe, kept = look(moved[chosen], chosen)
        aim = np.minimum(kept, most[chosen])
        short = aim - probe.distance
        bad = (short > np.maximum(_SHORT * np.abs(aim), scale * _SHORTEST)) & probe.normal.any(axis=1)
        if not bad.any():
            break
        out = chosen[bad]
        wrong[:] = False
        wrong[strands[out]] = True
        if turn % _PATIENCE < _PATIENCE - 1:
            normals[out] = probe.normal[bad]
            moved[out] += short[bad, None] * probe.normal[bad]
        else:
            align_with_neighbours(out, normals, moved)
    else:
        keep_lengths(after, normals, masses, moved)
    dx[:] = moved - after


@njit(cache=True)
def keep_lengths(after: np.ndarray, normals: np.ndarray, masses: np.ndarray, moved: np.ndarray) -> None:
    """Pull points towards their predecessors, from the root on, where segments are too long; moved in place."""
    way = np.empty(3)
    for i in range(1, len(moved)):
        if masses[i] == np.inf:  # A root: the point before it belongs to another strand.
            continue
        rest = length = along = 0.0
        for a in range(3):
            way[a] = moved[i, a] - moved[i - 1, a]
            rest += (after[i, a] - after[i - 1, a]) ** 2
            length += way[a] ** 2
            along += way[a] * normals[i, a]
        longest = (1.0 + STRETCH) ** 2 * rest
        if length <= longest:
            continue
        # Along the normal alone it is nearly too long: the whole way is shortened, not only that in the plane.
        if along**2 > _STEEPEST**2 * longest:
            along = 0.0
        # Shortens the way within the plane of contact only, so that the point slides and is not pulled back in.
        scale = np.sqrt((longest - along**2) / (length - along**2))
        for a in range(3):
            up = along * normals[i, a]
            moved[i, a] = moved[i - 1, a] + up + scale * (way[a] - up)


@njit(cache=True)
def align_with_neighbours(which: np.ndarray, normals: np.ndarray, moved: np.ndarray) -> None:
    """Lay points, ascending, where the plane of contact of the ones before them is, else nearer to these; in place."""
    for i in which:
        down = 0.0
        for a in range(3):
            down += (moved[i, a] - moved[i - 1, a]) * normals[i - 1, a]
        for a in range(3):
            way = moved[i, a] - moved[i - 1, a]
            moved[i, a] = moved[i - 1, a] + (way - down * normals[i - 1, a] if down < 0.0 else 0.5 * way)
            normals[i, a] = normals[i - 1, a]
