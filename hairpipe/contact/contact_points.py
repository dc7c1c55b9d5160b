"""Contacts between hairs at the start of a step: points, normals and loads.

A contact is fixed for the whole step: its two points and its normal do not change, and its gap is

    g = n . J x = n . (first point - second point),

linear in the positions and signed, so that hair that a prediction moved through another hair is still pushed back to
its original side. For two crossing segments n is normal to both and g is independent of sliding.

The scale of a scene: tolerances of contact follow it, so that a scene of another size has the same motion.

Lengths are in proportion to the distance d that hair keeps, times to sqrt(d / g), speeds to sqrt(d g), with g the
gravity: the similarity of Froude. Tolerances are written for the default distance under the Earth's gravity; a scene
without gravity has the times of this one.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.proximity import FARTHER, crossing_of
from hairpipe.geometry.segments import Pairs, mean_width
from hairpipe.geometry.vec3 import any_across, cross, dot, length, minus, plus, scaled, unit
from hairpipe.laws.repulsion import RELAXATION, repulsion
from hairpipe.laws.settings import Collisions

_EARTH = 9.81  # [m/s^2]


class Scale(NamedTuple):
    """Factors on tolerances of contact [1]."""

    length: float = 1.0
    time: float = 1.0
    speed: float = 1.0


USUAL = Scale()


def scale_of(distance: float, usual: float, gravity: float) -> Scale:
    """Return the scale of a scene; pure.

    distance  that hair keeps [m], and the `usual` one, for which tolerances are written
    gravity   [m/s^2]
    """
    length = distance / usual
    time = float(np.sqrt(length * _EARTH / (gravity or _EARTH)))
    return Scale(length, time, length / time)


REACH = 2.0
"""Search distance in thicknesses: pairs within it at the start of a step may touch before its end.

With only those that touch at the start, hair that falls on a stack would be caught when already inside.
"""
_COINCIDENT = 1e-9
"""Points nearer than this [m] have no direction between them."""


class Contacts(NamedTuple):
    """A set of contacts.

    segments   int32 (n, 2); fractions (n, 2): the two points, see `Pairs`
    normals    unit vectors from the second point to the first, (n, 3)
    loads      normal force at the end of the previous step [N], (n,)
    thickness  contact distance of the axes [m], (n,)
    shares     of the stiffness of a contact, (n,)
    """

    segments: np.ndarray
    fractions: np.ndarray
    normals: np.ndarray
    loads: np.ndarray
    thickness: np.ndarray
    shares: np.ndarray


def find_contacts(
    pairs: Pairs,
    points: np.ndarray,
    velocities: np.ndarray,
    collisions: Collisions,
    widths: np.ndarray | None = None,
    scale: Scale = USUAL,
    shares: np.ndarray | None = None,
) -> Contacts:
    """Make contacts of pairs at the beginning of a step; pure.

    points, velocities  [m], [m/s], (points, 3)
    widths              widths of segments in thicknesses of one hair, (points,); None: 1
    scale               factors on the time of relaxation
    shares              of contacts, see `approaches`, (n,); None: 1

    The stiff spring of a contact is implicit, so its force at the end of a step is its force in that step.
    """
    normals, loads, thickness = (np.empty((len(pairs.segments), *shape)) for shape in ((3,), (), ()))
    shares = np.ones(len(loads)) if shares is None else shares
    contacts = Contacts(pairs.segments, pairs.fractions, normals, loads, thickness, shares)
    widths = np.ones(len(points)) if widths is None else widths
    law = collisions.thickness.value, collisions.stiffness, collisions.stiffness * RELAXATION * scale.time
    _find(contacts, points, velocities, law, widths)
    return contacts


@inlined
def on_segment(x, k, s):
    """(1 - s) x_k + s x_(k+1)."""
    r = 1.0 - s
    return r * x[k, 0] + s * x[k + 1, 0], r * x[k, 1] + s * x[k + 1, 1], r * x[k, 2] + s * x[k + 1, 2]


@inlined
def between(x, segments, fractions, i):
    """First point of pair i minus its second one, (J x)_i."""
    return minus(
        on_segment(x, segments[i, 0], fractions[i, 0]),
        on_segment(x, segments[i, 1], fractions[i, 1]),
    )


@inlined
def inverse_mass(masses, segments, fractions, i):
    """1/M = sum w^2 / m over the four points of pair i [1/kg]: change of the relative velocity for a unit impulse."""
    total = 0.0  # Held points have mass inf and add 0.
    for j in range(2):
        k, s = segments[i, j], fractions[i, j]
        total += (1.0 - s) * (1.0 - s) / masses[k] + s * s / masses[k + 1]
    return total


@inlined
def apply(v, masses, segments, fractions, i, impulse):
    """Apply an impulse [N s] to the first place of pair i and its opposite to the second, in place."""
    for j in range(2):
        k = segments[i, j]
        s = fractions[i, j]
        sign = 1.0 - 2.0 * j
        for c in range(3):
            v[k, c] += sign * (1.0 - s) / masses[k] * impulse[c]
            v[k + 1, c] += sign * s / masses[k + 1] * impulse[c]


@inlined
def along(x, k):
    """x_(k+1) - x_k."""
    return x[k + 1, 0] - x[k, 0], x[k + 1, 1] - x[k, 1], x[k + 1, 2] - x[k, 2]


@inlined
def normal_of(x, v, segments, fractions, i):
    """Return the unit vector from the second point of pair i to the first.

    If the two coincide, it is normal to both segments and opposes the relative velocity; if these are also parallel,
    it opposes the normal component of the relative velocity; if that is zero, it is any normal of the first.
    """
    gap = between(x, segments, fractions, i)
    length = np.sqrt(dot(gap, gap))
    if length > _COINCIDENT:
        return scaled(1.0 / length, gap)
    a, b = along(x, segments[i, 0]), along(x, segments[i, 1])
    speed = between(v, segments, fractions, i)
    n = cross(a, b)
    aa = dot(a, a)
    nn = dot(n, n)
    if nn > 1e-12 * aa * dot(b, b):
        sign = -1.0 if dot(n, speed) > 0.0 else 1.0  # Back to the side that the first segment came from.
        return scaled(sign / np.sqrt(nn), n)
    if aa > 0.0:
        speed = minus(speed, scaled(dot(speed, a) / aa, a))
    ss = dot(speed, speed)
    if ss > 1e-12:
        return scaled(-1.0 / np.sqrt(ss), speed)
    return unit(any_across(a), (0.0, 1.0, 0.0))


@inlined
def _across_both(points, first, second, n):
    """Turn the normal n of a shared contact to that of both segments, as far as they cross and these two are alike.

    Otherwise a joint that another strand slides over would push it back from its sides: there n is upright, as far as a
    contact is shared. A tip that meets a joint end on keeps its normal.
    """
    both = cross(along(points, first), along(points, second))
    upright = dot(both, n) / max(length(both), 1e-300)
    part = crossing_of(points, first, second) * min(((1.0 + FARTHER) * upright) ** 2, 1.0)
    both = scaled(part / max(length(both), 1e-300) * (1.0 if upright > 0.0 else -1.0), both)
    return unit(plus(both, scaled(1.0 - part, n)), n)


@njit(cache=True, parallel=True, error_model="numpy")
def _find(contacts, points, velocities, law, widths):
    single, stiffness, viscosity = law
    segments, fractions, shares = contacts.segments, contacts.fractions, contacts.shares
    # By names of their own: numba loses what a parallel loop writes to fields of a tuple.
    normals, loads, thickness = contacts.normals, contacts.loads, contacts.thickness
    for i in prange(len(loads)):
        n = normal_of(points, velocities, segments, fractions, i)
        if shares[i] < 1.0:
            n = _across_both(points, segments[i, 0], segments[i, 1], n)
        gap = dot(n, between(points, segments, fractions, i))
        speed = dot(n, between(velocities, segments, fractions, i))
        normals[i, 0], normals[i, 1], normals[i, 2] = n
        # What comes near only now has not been slowed down yet.
        kept = single * mean_width(widths, segments, i)
        push = shares[i] * repulsion(stiffness, viscosity, kept - gap, max(speed, 0.0))
        loads[i] = max(push, 0.0) if gap < kept else 0.0
        thickness[i] = kept
