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
from numba import njit, prange

from hairpipe.sim.contact.contacts import apply, between, impulse, inverse_mass
from hairpipe.sim.contact.crossings import Crossings, crossings
from hairpipe.sim.contact.swept import neighbourhood, swept_pairs, swept_pairs_of
from hairpipe.sim.forces.vectors import dot, minus, plus, scaled
from hairpipe.sim.scene import Collisions

_SWEEPS = 8
_LEAST = 0.01
_LOOK = 0.5
"""Thicknesses within which pairs are listed: none is missed when impulses move both by less than half of that, and what
moves farther is looked for anew. To look for the few again is cheaper than to list what is near all."""


class Outcome(NamedTuple):
    """What became of the crossings of a step.

    found   pairs of segments that would have crossed; left: that still do
    change  of the velocities of points [m/s], which end so many times the step away from where they would,
            (points, 3)
    """

    found: int
    left: int
    change: np.ndarray


def collide(
    before: np.ndarray,
    after: np.ndarray,
    masses: np.ndarray,
    offsets: np.ndarray,
    dt: float,
    collisions: Collisions,
    ignored: np.ndarray | None = None,
) -> Outcome:
    """Find what keeps hair from passing through hair in a step; pure.

    before, after  positions [m], (points, 3)
    masses         of the points, inf where they are held [kg], (points,)
    offsets        of the strands, (strands+1,) int32
    dt             step [s]
    ignored        keys of pairs that may cross, sorted
    """
    look = _LOOK * collisions.thickness
    around = neighbourhood(before, after, offsets, look)
    near = swept_pairs(around, ignored)
    met = crossings(before, after, near)
    found, known = len(met.times), [met]
    change, ends = np.zeros(after.shape), after.copy()
    rule = (collisions.thickness, collisions.friction, dt)
    for _ in range(collisions.attempts):
        if not len(met.times):
            break
        together = _in_time(known)
        points = _points_of(together.segments, len(before))
        previous = change[points]
        _solve(change, before, after, masses, together, rule)
        ends[points] = after[points] + dt * change[points]
        struck = points[(change[points] != previous).any(axis=1)]
        listed = near[_among(near, _touched(struck, len(before)))]
        far = points[2.0 * dt * np.abs(change[points]).max(axis=1) * np.sqrt(3.0) > look]
        if len(far):
            touched = _touched(far, len(before))
            touched[offsets[1:] - 1] = False  # where no segment begins
            fresh = swept_pairs_of(around, np.flatnonzero(touched).astype(np.int32), before, ends, ignored)
            listed = np.concatenate([listed[~_among(listed, touched)], fresh])
        met = crossings(before, ends, listed)
        known.append(met)
    return Outcome(found, len(met.times), change)


def _in_time(known: list[Crossings]) -> Crossings:
    """Put crossings behind one another, the earliest in the step first."""
    together = Crossings(*(np.concatenate(parts) for parts in zip(*known, strict=True)))
    order = np.argsort(together.times, kind="stable")
    return Crossings(*(part[order] for part in together))


def _points_of(segments: np.ndarray, count: int) -> np.ndarray:
    """List the points, of so many, of segments, (n, 2), ascending, (m,)."""
    marked = np.zeros(count, np.bool_)
    marked[segments] = True
    marked[segments + 1] = True
    return np.flatnonzero(marked)


def _touched(points: np.ndarray, count: int) -> np.ndarray:
    """Mark where a segment with one of some points would begin, (count,) bool."""
    touched = np.zeros(count, np.bool_)
    touched[points] = True
    touched[points[points > 0] - 1] = True
    return touched


@njit(cache=True, parallel=True)
def _among(pairs, marked):  # noqa: ANN001, ANN202
    """Mark the pairs, (n, 2), of which one is marked, (n,) bool."""
    among = np.empty(len(pairs), np.bool_)
    for k in prange(len(pairs)):
        among[k] = marked[pairs[k, 0]] or marked[pairs[k, 1]]
    return among


@njit(cache=True, error_model="numpy")
def _solve(change, before, after, masses, met, rule):  # noqa: ANN001, ANN202
    """Add the effect of impulses to the change of velocity, crossing by crossing, in place."""
    thickness, friction, dt = rule
    segments, fractions, normals = met.segments, met.fractions, met.normals
    for _ in range(_SWEEPS):
        for i in range(len(segments)):
            w = inverse_mass(masses, segments, fractions, i)
            if w == 0.0:
                continue
            n = (normals[i, 0], normals[i, 1], normals[i, 2])
            begun, ended = between(before, segments, fractions, i), between(after, segments, fractions, i)
            gap, u = dot(n, begun), plus(scaled(1.0 / dt, minus(ended, begun)), between(change, segments, fractions, i))
            end = min(max(gap, _LEAST * thickness), thickness)
            dv = (end - gap) / dt - dot(n, u)
            if dv > 1e-12 * np.sqrt(dot(u, u)):
                apply(change, masses, segments, fractions, i, impulse(u, n, dv, friction, 1.0 / w))
