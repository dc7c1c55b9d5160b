"""Connections of stiction: segments that came close stick until they are pulled apart; the law is `laws/adhesion.py`.

A connection joins the closest points of its segments at its creation. Connections are broken and created at the start
of a step.

A connection that pushes does so in its direction at the start of the step, as a contact does. A push along the
direction at the prediction grows with the motion that turns it, and no stiffness in the matrix answers: hair in
equilibrium would gain speed from step to step, as hairs that stick nearer than the reach did.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import between, inverse_mass, normal_of
from hairpipe.geometry.proximity import near_pairs
from hairpipe.geometry.segments import Pairs, key_of, mean_width
from hairpipe.geometry.sorting import places_of, rows_at
from hairpipe.geometry.vec3 import dot, scaled
from hairpipe.laws.adhesion import adhesion, stiffness_of
from hairpipe.laws.settings import Stiction
from hairpipe.solve.couplings import ACROSS, ALONG, DIRECTION, PUSH, Couplings
from hairpipe.solve.interactions import Prediction, Start


class Connections(NamedTuple):
    """Connections of stiction.

    segments   first < second, rows in lexicographic order, (n, 2) int32
    fractions  positions on the segments, constant while the connection lasts, (n, 2)
    """

    segments: np.ndarray
    fractions: np.ndarray


def no_connections() -> Connections:
    """Make an empty set."""
    return Connections(np.empty((0, 2), np.int32), np.empty((0, 2)))


def release(connections: Connections, points: np.ndarray, distance: float, widths: np.ndarray) -> Connections:
    """Return the connections that are not longer than a distance [m]; points  [m], (points, 3); widths  as below."""
    kept = np.empty(len(connections.segments), np.bool_)
    _hold_on(kept, connections, points, distance, widths)
    places = places_of(kept)
    return connections if len(places) == len(kept) else Connections(*(rows_at(each, places) for each in connections))


def room(connections: Connections, points: int, closest: int) -> np.ndarray:
    """Count the connections that segments may still get, of so many that each may have, (points,) int64."""
    return closest - np.bincount(connections.segments.ravel(), minlength=points)


def connect(connections: Connections, candidates: Pairs) -> Connections:
    """Add pairs that are not connected yet; that they find `room` is the business of `closest_pairs`."""
    if not len(candidates.segments):
        return connections
    count = len(connections.segments) + len(candidates.segments)
    out = Connections(np.empty((count, 2), np.int32), np.empty((count, 2)))
    old, new = key_of(connections.segments), key_of(candidates.segments)
    _insert(old, new, connections.segments, connections.fractions, *out)
    _insert(new, old, candidates.segments, candidates.fractions, *out)
    return out


def linearise(
    connections: Connections,
    began: Start,
    at: Prediction,
    stiction: Stiction,
    out: Couplings,
    widths: np.ndarray,
    grips: np.ndarray,
) -> None:
    """Linearise the forces of connections at a prediction, in place: sets all of out except segments and fractions.

    began   the start of the step, for the directions of connections that push
    widths  widths of segments, (points,): two of widths a and b have (a + b) / 2 times reach and release
    grips   square roots of the forces of segments over that of the settings, (points,)

    Connections of non-finite strands, or between two inactive strands, do not act.
    """
    law = (stiffness_of(stiction), stiction.reach, stiction.release, stiction.damping)
    _linearise(out, connections, began, at, law, widths, grips)


def same_hair_keys(points: np.ndarray, offsets: np.ndarray, reach: float) -> np.ndarray:
    """List pairs of segments of one hair within reach at rest: a curl does not stick to itself.

    points   points of the groom [m], (points, 3); offsets  offsets of its strands, (strands+1,) int32
    returns  sorted keys, see `key_of`, (n,) int64
    """
    segments = near_pairs(points, offsets, reach).segments
    strands = np.searchsorted(offsets, segments, side="right")
    return key_of(segments[strands[:, 0] == strands[:, 1]])


def stiffest(connections: Connections, masses: np.ndarray, stiction: Stiction, grips: np.ndarray) -> float:
    """Bound the share of connections in the squared highest frequency: max_p sum_i 4 k |w_i| / m_p [1/s^2].

    masses  masses of the points, inf if held [kg], (points,); grips  as of `linearise`

    The sum runs over the connections at a point, like that over springs in `step_size.py`, to which it is added.
    """
    segments, fractions = connections
    share = np.repeat(grips[segments].prod(axis=1), 2)
    weights = np.bincount(segments.ravel(), share * (1.0 - fractions.ravel()), len(masses))
    weights += np.bincount(segments.ravel() + 1, share * fractions.ravel(), len(masses))
    return 4.0 * stiffness_of(stiction) * float((weights / masses).max(initial=0.0))


@njit(cache=True, parallel=True)
def _hold_on(kept, connections, points, distance, widths):
    for i in prange(len(kept)):
        span = between(points, connections.segments, connections.fractions, i)
        far = distance * mean_width(widths, connections.segments, i)
        kept[i] = dot(span, span) <= far * far  # NaN is not kept: a connection of a lost strand breaks.


@njit(cache=True, parallel=True)
def _insert(keys, others, segments, fractions, all_segments, all_fractions):
    """Write connections to where they belong among others, none of which are the same, in place."""
    for k in prange(len(keys)):
        place = k + np.searchsorted(others, keys[k])
        for j in range(2):
            all_segments[place, j], all_fractions[place, j] = segments[k, j], fractions[k, j]


@njit(cache=True, parallel=True, error_model="numpy")
def _linearise(out, connections, began, at, law, widths, grips):
    single, reach, far, fraction = law
    points, velocities, masses, weights, span = at.points, at.velocities, at.masses, at.weights, at.span
    segments, fractions = connections.segments, connections.fractions
    # By names of their own: numba loses what a parallel loop writes to fields of a tuple.
    acts, exerted = out.acts, out.exerted
    for i in prange(len(acts)):
        acts[i] = False
        if not (at.active[segments[i, 0]] or at.active[segments[i, 1]]):  # Neither strand is solved.
            continue
        apart, u = between(points, segments, fractions, i), between(velocities, segments, fractions, i)
        length, speed = np.sqrt(dot(apart, apart)), np.sqrt(dot(u, u))
        if length < np.inf and speed < np.inf:
            wide = mean_width(widths, segments, i)
            longer = length - wide * reach
            if longer > 0.0:
                d = scaled(1.0 / length, apart)
            else:
                d = normal_of(began.points, began.velocities, segments, fractions, i)
            slack = wide * (far - reach)
            stiffness = single * (grips[segments[i, 0]] * grips[segments[i, 1]]) / wide
            w = inverse_mass(masses, segments, fractions, i)
            k, c = adhesion(stiffness, fraction, longer, slack, w)
            # One h for both strands, so that what they exert on each other is opposite.
            h = 0.5 * (weights[segments[i, 0]] + weights[segments[i, 1]])
            pull = k * longer
            force = -span * (pull + c * dot(u, d))
            acts[i] = True
            exerted[i, ALONG] = span * (h * k + c)
            exerted[i, ACROSS] = span * h * pull / length if longer > 0.0 else 0.0
            for a in range(3):
                exerted[i, DIRECTION + a], exerted[i, PUSH + a] = d[a], force * d[a]
