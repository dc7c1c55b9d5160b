"""Elongations of the friction between hairs, over steps and from one segment to the next; the law is `coulomb.py`.

A contact that slides over a joint becomes one of the next segment: a pair without an elongation takes over that of a
pair next to it.
"""

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import Contacts, between
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segments import key_of
from hairpipe.geometry.vec3 import dot, flattened, length, minus, plus, row, scaled
from hairpipe.laws.settings import Collisions
from hairpipe.values.hair import Shear

AROUND = ((0, 0), (0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))
"""Steps from a pair of segments to itself and to those next to it."""


def no_shear() -> Shear:
    """Make the elongations of no contacts."""
    return Shear(np.empty((0, 2), np.int32), np.empty((0, 3)))


def anchor(contacts: Contacts, points: np.ndarray, known: Shear, collisions: Collisions) -> np.ndarray:
    """Return what J x has to be added to for the elongations of contacts in a step [m], (n, 3); pure.

    points  at the start of the step [m], (P, 3)
    known   elongations at the end of the previous step
    """
    anchors = np.empty((len(contacts.loads), 3))
    limit = collisions.friction / collisions.stiffness
    _anchor(anchors, contacts, points, key_of(known.segments), known.elongations, limit)
    return anchors


def sheared(contacts: Contacts, points: np.ndarray, anchors: np.ndarray) -> Shear:
    """Return the elongations of the contacts that are closed at points [m], (P, 3), at the end of a step; pure."""
    elongations = np.empty_like(anchors)
    closed = np.empty(len(anchors), np.bool_)
    _shear(elongations, closed, contacts, points, anchors)
    return Shear(contacts.segments[closed], elongations[closed])


@njit(cache=True, parallel=True)
def _anchor(anchors, contacts, points, keys, elongations, per_load):
    segments, fractions, loads, normals = contacts.segments, contacts.fractions, contacts.loads, contacts.normals
    for i in prange(len(anchors)):
        s = (0.0, 0.0, 0.0)
        if loads[i] > 0.0:
            k = _find(keys, segments[i, 0], segments[i, 1])
            if k >= 0:
                s = flattened(row(elongations, k), row(normals, i))
                s = scaled(min(per_load * loads[i] / max(length(s), 1e-12), 1.0), s)
        anchors[i, 0], anchors[i, 1], anchors[i, 2] = minus(s, between(points, segments, fractions, i))


@inlined
def _find(keys, first, second):
    """Return the place of a pair of segments among sorted keys, else of a pair next to it; -1 without any."""
    for a, b in AROUND:
        key = np.int64(first + a) << 32 | np.int64(second + b)
        k = np.searchsorted(keys, key)
        if k < len(keys) and keys[k] == key:
            return k
    return -1


@njit(cache=True, parallel=True)
def _shear(elongations, closed, contacts, points, anchors):
    segments, fractions, normals, thickness = (
        contacts.segments,
        contacts.fractions,
        contacts.normals,
        contacts.thickness,
    )
    for i in prange(len(closed)):
        apart = between(points, segments, fractions, i)
        n = row(normals, i)
        closed[i] = dot(n, apart) < thickness[i]  # Not for NaN: a lost strand touches nothing.
        s = flattened(plus(row(anchors, i), apart), n)
        elongations[i, 0], elongations[i, 1], elongations[i, 2] = s
