"""Steps 3 and 9 as published: repulsions pair by pair, by impulses, after Bridson et al. 2002, Sec. 7.2 to 7.3.

For a pair at distance d with relative velocity u, normal n and 1/M = sum w^2 / m, in the order of the pairs:

    inelastic   the approach n.u is stopped; farther than the thickness, slowed down to what closes a tenth of the
                room in a step: dv = max(0, -a (d - h)+ / dt - n.u),   a = 0.1
    elastic     a tenth of the overlap is undone in a step, if the spring is strong enough for that:
                dv = min(a (h - d) / dt - n.u, dt k (h - d) / M),   where that is positive
    friction    |u_t| falls by at most mu dv

The impulses are +- M (dv n + change of u_t). Step 3 does all of it, step 9 leaves out the elastic part, as the authors'
code. Pairs whose closest point is an end of a segment are left out, also as in their code.

In a stack an impulse travels one layer per sweep, so this is far from convergence with an affordable number of sweeps:
`graphs/experiments/stack.toml` compares it with `repulsion.py`, which serves stacks.

We differ from the authors' code, which applies friction in a separate pass, before the approach is stopped; here, as
in Bridson et al., it is part of each impulse, so that Coulomb's law holds for each.
"""

import numpy as np
from numba import njit

from hairpipe.contact.contact_points import apply, between, find_contacts, inverse_mass
from hairpipe.geometry.segments import Pairs
from hairpipe.geometry.vec3 import dot
from hairpipe.laws.coulomb import impulse
from hairpipe.laws.settings import Collisions

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
