"""Repulsion between hairs by springs in the linear system of a stage, as stacks need, with friction.

Along the normal of a contact acts the law of `laws/repulsion.py`, along the contact Coulomb's, `laws/coulomb.py`. Its
load N is that at the start of the step or, if larger, the force that would stop the two segments alone: the first is
right for hair at rest, where the second ignores the stack above, and the second for impacts.

If the solve is linearised at rest (backward Euler, the paper's half steps), the prediction has no velocity, and the
way along the contact, N and new contacts are computed from the motion with lagged_velocity.

A contact acts if it would push at the prediction, or did so in the step before: it is released one step late. By the
prediction alone, which lacks the forces of the stage, a trembling contact at rest falls by h^2 g, half its thickness,
before it is caught again, and a stack collapses (`graphs/experiments/stack.toml`).

We differ from the paper, which adapts Bridson et al. 2002, impulses pair by pair (`sweep`): they do not
converge in stacks. The authors' code also leaves out pairs whose closest point is an end of a segment. We include
them: nearly parallel segments, as nearly all neighbours in hair are, always have their closest point there, and so has
a tip that rests on another hair. Pairs of consecutive segments share a contact (`geometry/proximity.py`): one that
slides over a joint passes from one to the next without a jump. Their springs have these shares of the stiffness, so
that their forces and loads add up to those of one contact.

Elongations of the friction between hairs, over steps and from one segment to the next; the law is `coulomb.py`.

A contact that slides over a joint becomes one of the next segment: a pair without an elongation takes over that of a
pair next to it.

Steps 3 and 9 as published: repulsions pair by pair, by impulses, after Bridson et al. 2002, Sec. 7.2 to 7.3.

For a pair at distance d with relative velocity u, normal n and 1/M = sum w^2 / m, in the order of the pairs:

    inelastic   the approach n.u is stopped; farther than the thickness, slowed down to what closes a tenth of the
                room in a step: dv = max(0, -a (d - h)+ / dt - n.u),   a = 0.1
    elastic     a tenth of the overlap is undone in a step, if the spring is strong enough for that:
                dv = min(a (h - d) / dt - n.u, dt k (h - d) / M),   where that is positive
    friction    |u_t| falls by at most mu dv

The impulses are +- M (dv n + change of u_t). Step 3 does all of it, step 9 leaves out the elastic part, as the authors'
code. Pairs whose closest point is an end of a segment are left out, also as in their code.

In a stack an impulse travels one layer per sweep, so this is far from convergence with an affordable number of sweeps:
`graphs/experiments/stack.toml` compares it with the springs, which serve stacks.

We differ from the authors' code, which applies friction in a separate pass, before the approach is stopped; here, as
in Bridson et al., it is part of each impulse, so that Coulomb's law holds for each.
"""

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import USUAL, Contacts, Scale, apply, between, find_contacts, inverse_mass
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segments import Pairs, key_of
from hairpipe.geometry.vec3 import dot, flattened, length, minus, plus, row, scaled
from hairpipe.laws.coulomb import elongated, impulse
from hairpipe.laws.repulsion import RELAXATION, repulsion, repulsion_slope
from hairpipe.laws.settings import Collisions
from hairpipe.solve.couplings import ACROSS, ALONG, DIRECTION, PUSH, Couplings
from hairpipe.solve.interactions import Prediction
from hairpipe.values.hair import Shear


def linearise(
    contacts: Contacts,
    anchors: np.ndarray,
    at: Prediction,
    collisions: Collisions,
    out: Couplings,
    scale: Scale = USUAL,
) -> None:
    """Linearise contact forces at a prediction, in place: sets all of out except segments and fractions.

    anchors  of the contacts [m], (n, 3), see `friction.anchor`
    scale    factors on times and speeds

    Contacts of non-finite strands, or between two inactive strands, do not act.
    """
    law = collisions.stiffness, RELAXATION * scale.time, collisions.friction
    _linearise(out, contacts, anchors, at, law)


@njit(cache=True, parallel=True, error_model="numpy")
def _linearise(out, contacts, anchors, at, law):
    whole, relaxation, friction = law
    points, velocities, masses, weights, span = at.points, at.velocities, at.masses, at.weights, at.span
    segments, fractions = contacts.segments, contacts.fractions
    # By names of their own: numba loses what a parallel loop writes to fields of a tuple.
    acts, exerted = out.acts, out.exerted
    for i in prange(len(acts)):
        acts[i] = False
        if not (at.active[segments[i, 0]] or at.active[segments[i, 1]]):
            continue
        n = (contacts.normals[i, 0], contacts.normals[i, 1], contacts.normals[i, 2])
        apart = between(points, segments, fractions, i)
        overlap = contacts.thickness[i] - dot(n, apart)
        u = between(velocities, segments, fractions, i)
        coming = between(at.lagged_velocity, segments, fractions, i)
        un, closing = dot(n, u), dot(n, coming)
        h = 0.5 * (weights[segments[i, 0]] + weights[segments[i, 1]])
        stiffness = whole * contacts.shares[i]
        viscosity = stiffness * relaxation
        ahead = overlap - h * (closing - un)  # By the lagged velocity, as a solve may be linearised at rest.
        force = repulsion(stiffness, viscosity, overlap, un)
        load = repulsion(stiffness, viscosity, ahead, closing)
        # A loaded contact acts one step longer than it pushes: hair at rest would lose and catch it in turns.
        if np.isfinite(force + load) and (contacts.loads[i] > 0.0 or (ahead > 0.0 and load > 0.0)):
            w = inverse_mass(masses, segments, fractions, i)
            along = span * repulsion_slope(stiffness, viscosity, h)
            # The load of the last step holds a stack at rest; what stops the pair alone is the load of an impact.
            limit = friction * max(contacts.loads[i], load / (1.0 + along * w))
            s = flattened(plus(row(anchors, i), apart), n)
            slowed = 0.0 if contacts.loads[i] > 0.0 else span * (h + relaxation) * limit * w
            c, e = elongated(s, flattened(u, n), flattened(coming, n), h, stiffness, relaxation, limit, slowed)
            acts[i] = True
            exerted[i, ALONG] = along
            exerted[i, ACROSS] = span * (h + relaxation) * c
            for a in range(3):
                exerted[i, DIRECTION + a] = n[a]
                exerted[i, PUSH + a] = span * (force * n[a] - c * e[a])


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
                s = scaled(min(per_load * loads[i] / (contacts.shares[i] * max(length(s), 1e-12)), 1.0), s)
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
    for i in prange(len(closed)):
        apart = between(points, contacts.segments, contacts.fractions, i)
        n = row(contacts.normals, i)
        closed[i] = dot(n, apart) < contacts.thickness[i]  # Not for NaN: a lost strand touches nothing.
        s = flattened(plus(row(anchors, i), apart), n)
        elongations[i, 0], elongations[i, 1], elongations[i, 2] = s


_SHARE = 0.1
"""Of the distance to the thickness, closed or undone in a step."""


def sweep(
    pairs: Pairs,
    points: np.ndarray,
    velocities: np.ndarray,
    masses: np.ndarray,
    collisions: Collisions,
    dt: float,
    widths: np.ndarray | None = None,
    *,
    elastic: bool,
) -> None:
    """Change velocities so that pairs do not come closer, in place.

    points      [m], velocities [m/s], (points, 3)
    masses      inf for held points [kg], (points,)
    dt          step [s]
    widths      of segments in thicknesses of the settings, (points,); None: 1
    elastic     whether overlaps are also reduced
    """
    contacts = find_contacts(pairs, points, velocities, collisions, widths)
    rule = (collisions.friction, collisions.stiffness, dt)
    _sweep(velocities, pairs, contacts, masses, rule, collisions.sweeps, elastic)


@njit(cache=True, error_model="numpy")
def _sweep(v, pairs, contacts, masses, rule, sweeps, elastic):
    """One pair after the other: each sees what those before it did."""
    friction, stiffness, dt = rule
    segments, fractions, normals = pairs.segments, pairs.fractions, contacts.normals
    for turn in range(sweeps + elastic):
        for i in range(len(segments)):  # In the order of the pairs, on one thread: the result depends on it.
            s, t = fractions[i]
            w = inverse_mass(masses, segments, fractions, i)
            if w == 0.0 or not (0.0 < s < 1.0 and 0.0 < t < 1.0):
                continue
            n = (normals[i, 0], normals[i, 1], normals[i, 2])
            room = pairs.distances[i] - contacts.thickness[i]  # Those of the beginning: sweeps change velocities only.
            u = between(v, segments, fractions, i)
            un = dot(n, u)
            if turn < sweeps:
                dv = -_SHARE * max(room, 0.0) / dt - un
            else:
                dv = min(-_SHARE * room / dt - un, -dt * stiffness * w * room)
            if dv > 0.0:
                apply(v, masses, segments, fractions, i, impulse(u, n, dv, friction, 1.0 / w))
