"""Repulsion between hairs by springs in the linear system of a stage, as stacks need, with friction.

Along the normal of a contact acts the law of `laws/repulsion.py`, along the contact Coulomb's, `laws/coulomb.py`. Its
load N is that at the start of the step or, if larger, the force that would stop the two segments alone: the first is
right for hair at rest, where the second ignores the stack above, and the second for impacts.

If the solve is linearised at rest (backward Euler, the paper's half steps), the prediction has no velocity, and the
way along the contact, N and new contacts are computed from the motion with lagged_velocity.

A contact acts if it would push at the prediction, or did so in the step before: it is released one step late. By the
prediction alone, which lacks the forces of the stage, a trembling contact at rest falls by h^2 g, half its thickness,
before it is caught again, and a stack collapses (`graphs/experiments/stack.toml`).

We differ from the paper, which adapts Bridson et al. 2002, impulses pair by pair (`impulses.py`): they do not
converge in stacks. The authors' code also leaves out pairs whose closest point is an end of a segment. We include
them: nearly parallel segments, as nearly all neighbours in hair are, always have their closest point there, and so has
a tip that rests on another hair. Of consecutive segments near the same segment, the nearest has the contact
(`geometry/proximity.py`): a contact that slides over their joint passes from one to the next at the same point, with
the same force. Where that other segment also ends, both pairs share a contact and both springs act; Coulomb's law
still holds: the two loads add up to one.
"""

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import USUAL, Contacts, Scale, between, inverse_mass
from hairpipe.geometry.vec3 import dot, flattened, plus, row
from hairpipe.laws.coulomb import elongated
from hairpipe.laws.repulsion import RELAXATION, repulsion, repulsion_slope
from hairpipe.laws.settings import Collisions
from hairpipe.solve.couplings import ACROSS, ALONG, DIRECTION, PUSH, Couplings
from hairpipe.solve.interactions import Prediction


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
    stiffness, relaxation, friction = law
    viscosity = stiffness * relaxation
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
