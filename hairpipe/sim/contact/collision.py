"""Step 6: hair that would pass through hair in a step does not, after Bridson et al. 2002, edges against edges.

A crossing at the fractions s, t of two segments, with normal n, has the gap g0 = n.J x0 before the step and n.J x1 =
g0 + dt n.u after it, u = J (x1 - x0) / dt. An impulse at these points changes n.u so that the gap ends at g:

    g = g0, but at most the thickness that is kept, and at least a hundredth of it;   dv = (g - g0) / dt - n.u > 0

with restitution 0 and Coulomb friction. Impulses change x1 and v alike, by dt and by 1 times their effect on u. What
they bring together anew is looked for among the pairs that they moved and added to what is solved, up to so many times;
crossings that then are left are accepted: no rigid zones, as published, since no state of hair is invalid.

We differ from the paper, where an impulse stops the approach of the whole step, as if hair touched where it began: here
it comes as near as the thickness. And every attempt goes over the crossings of all before it, several times, so that
solving one does not undo another.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.sim.contact.contacts import apply, between, impulse, inverse_mass
from hairpipe.sim.contact.crossings import Crossings, crossings
from hairpipe.sim.contact.found import in_order
from hairpipe.sim.contact.swept import neighbourhood, swept_pairs, swept_pairs_of
from hairpipe.sim.forces.vectors import dot
from hairpipe.sim.scene import Collisions

_SWEEPS = 8
_LEAST = 0.01
_LOOK = 2.0
"""Thicknesses within which pairs are listed: none is missed when impulses move both by less than half of that, and what
moves farther is looked for anew."""


class Outcome(NamedTuple):
    """What became of the crossings of a step.

    found  pairs of segments that would have crossed; left: that still do
    moved  points whose way was changed, (points,) bool
    """

    found: int
    left: int
    moved: np.ndarray


def collide(
    before: np.ndarray,
    after: np.ndarray,
    velocities: np.ndarray,
    masses: np.ndarray,
    offsets: np.ndarray,
    dt: float,
    collisions: Collisions,
    ignored: np.ndarray | None = None,
) -> Outcome:
    """Keep hair from passing through hair in a step; changes after and velocities, in place.

    before, after  positions [m], velocities [m/s], (points, 3)
    masses         of the points, inf where they are held [kg], (points,)
    offsets        of the strands, (strands+1,) int32
    dt             step [s]
    ignored        keys of pairs that may cross, sorted
    """
    look = _LOOK * collisions.thickness
    around = neighbourhood(before, after, offsets, look)
    near = swept_pairs(around, look, ignored)
    met = crossings(before, after, near)
    found, known = len(met.times), [met]
    change, moved = np.zeros_like(after), np.zeros(len(after), bool)
    mean, ends, is_segment = (after - before) / dt, after, np.isin(np.arange(len(before)), offsets[1:] - 1, invert=True)
    rule = (collisions.thickness, collisions.friction, dt)
    for _ in range(collisions.attempts):
        if not len(met.times):
            break
        previous = change.copy()
        _solve(change, mean, before, masses, _in_time(known), rule)
        ends, struck = after + dt * change, (change != previous).any(axis=1)
        moved |= struck
        listed = near[_touched(struck)[near].any(axis=1)]
        far = 2.0 * dt * np.abs(change).max(axis=1) * np.sqrt(3.0) > look
        if far.any():
            segments = np.flatnonzero(_touched(far) & is_segment).astype(np.int32)
            fresh = swept_pairs_of(around, segments, before, ends, look, ignored)
            listed = in_order(np.concatenate([listed, fresh]), len(before))
        met = crossings(before, ends, listed)
        known.append(met)
    after[moved] = ends[moved]
    velocities[moved] += change[moved]
    return Outcome(found, len(met.times), moved)


def _in_time(known: list[Crossings]) -> Crossings:
    """Put crossings behind one another, the earliest in the step first."""
    together = Crossings(*(np.concatenate(parts) for parts in zip(*known, strict=True)))
    order = np.argsort(together.times, kind="stable")
    return Crossings(*(part[order] for part in together))


def _touched(struck: np.ndarray) -> np.ndarray:
    """Mark segments with a point that was struck, (P,) bool."""
    touched = struck.copy()
    touched[:-1] |= struck[1:]
    return touched


@njit(cache=True, error_model="numpy")
def _solve(change, mean, before, masses, met, rule):  # noqa: ANN001, ANN202
    """Add the effect of impulses to the change of velocity, crossing by crossing, in place."""
    thickness, friction, dt = rule
    segments, fractions, normals = met.segments, met.fractions, met.normals
    for _ in range(_SWEEPS):
        for i in range(len(segments)):
            w = inverse_mass(masses, segments, fractions, i)
            if w == 0.0:
                continue
            n = (normals[i, 0], normals[i, 1], normals[i, 2])
            gap = dot(n, between(before, segments, fractions, i))
            a, b = between(mean, segments, fractions, i), between(change, segments, fractions, i)
            u = (a[0] + b[0], a[1] + b[1], a[2] + b[2])
            end = min(max(gap, _LEAST * thickness), thickness)
            dv = (end - gap) / dt - dot(n, u)
            if dv > 1e-12 * np.sqrt(dot(u, u)):
                apply(change, masses, segments, fractions, i, impulse(u, n, dv, friction, 1.0 / w))
