"""Step 6: collisions between hairs in a step, after Bridson et al. 2002, edges against edges.

A crossing at the fractions s, t of two segments, with normal n, has the gap g0 = n.J x0 before the step and n.J x1 =
g0 + dt n.u after it, u = J (x1 - x0) / dt. An impulse at these points changes n.u so that the gap ends at g:

    g = g0, but at most the thickness that is kept, and at least a hundredth of it;   dv = (g - g0) / dt - n.u > 0

with restitution 0 and Coulomb friction. Impulses change x1 and v alike, by dt and by 1 times their effect on u. New
crossings are searched among the pairs that they moved and added to the solve, up to a number of attempts; the
remaining crossings are accepted: no rigid zones, as published, since no state of hair is invalid.

We differ from the paper, where an impulse stops the approach of the whole step, as if hair touched at its start: here
hair approaches up to the thickness. And every attempt iterates over the crossings of all previous attempts several
times, so that one solution does not undo another.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.vec3 import dot, minus, plus, scaled
from hairpipe.sim.contact.ccd.broad_phase import Candidates
from hairpipe.sim.contact.ccd.crossings import Crossings, crossings
from hairpipe.sim.contact.contact_points import apply, between, impulse, inverse_mass
from hairpipe.sim.settings import Collisions
from hairpipe.spatial.pairs import mean_width

_SWEEPS = 8
_LEAST = 0.01
_LOOK = 0.5
"""Search distance of candidates, in thicknesses: to search again for the few that impulses move by more than half of
that is cheaper than to list a wider neighbourhood of all."""


class Outcome(NamedTuple):
    """Result of the crossings of a step.

    found   pairs of segments that would have crossed; left: pairs that still cross
    change  change of the velocities of points [m/s], whose ends move by it times the step, (points, 3)
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
    widths: np.ndarray | None = None,
) -> Outcome:
    """Find the changes that prevent hair from crossing hair in a step; pure.

    before, after  positions [m], (points, 3)
    masses         masses of the points, inf if held [kg], (points,)
    offsets        offsets of the strands, (strands+1,) int32
    dt             step [s]
    ignored        sorted keys of pairs allowed to cross
    widths         of segments in thicknesses of the settings, (points,); None: 1
    """
    thickness = collisions.thickness.value
    widths = np.ones(len(before)) if widths is None else widths
    candidates = Candidates(before, after, offsets, _LOOK * thickness, ignored)
    met = crossings(before, after, candidates.pairs)
    found = len(met.times)
    together = met
    change, previous = np.zeros(after.shape), np.zeros(after.shape)
    ends = np.empty_like(after)
    struck = np.empty(len(after), np.bool_)
    for attempt in range(collisions.attempts):
        if not len(met.times):
            break
        together = _in_time(met) if attempt == 0 else _in_time(together, met)
        passages = _passages(before, after, masses, together, thickness, widths, dt)
        _solve(change, passages, masses, together.segments, together.fractions, collisions.friction)
        _end(after, previous, change, dt, ends, struck)
        candidates.renew(ends)
        met = crossings(before, ends, candidates.of(struck))
    return Outcome(found, len(met.times), change)


def _in_time(*known: Crossings) -> Crossings:
    """Concatenate crossings, the earliest in the step first."""
    together = Crossings(*(np.concatenate(parts) for parts in zip(*known, strict=True)))
    order = np.argsort(together.times, kind="stable")
    return Crossings(*(part[order] for part in together))


@njit(cache=True, parallel=True)
def _end(after, previous, change, dt, ends, struck):
    """Find where points end, (P, 3), mark those whose change of velocity was another before, (P,) bool, and note it."""
    for k in prange(len(after)):
        struck[k] = False
        for c in range(3):
            ends[k, c] = after[k, c] + dt * change[k, c]
            struck[k] |= change[k, c] != previous[k, c]  # Exactly: only pairs with a changed point are searched again.
            previous[k, c] = change[k, c]


@njit(cache=True, parallel=True, error_model="numpy")
def _passages(before, after, masses, met, thickness, widths, dt):
    """Return every crossing without impulses: n, u [m/s], target n.u [m/s], mass of the pair [kg] or 0, (n, 8)."""
    segments, fractions, normals = met.segments, met.fractions, met.normals
    passages = np.empty((len(segments), 8))
    for i in prange(len(segments)):
        w = inverse_mass(masses, segments, fractions, i)
        n = (normals[i, 0], normals[i, 1], normals[i, 2])
        begun, ended = between(before, segments, fractions, i), between(after, segments, fractions, i)
        gap = dot(n, begun)
        u = scaled(1.0 / dt, minus(ended, begun))
        kept = thickness * mean_width(widths, segments, i)
        end = min(max(gap, _LEAST * kept), kept)
        for c in range(3):
            passages[i, c], passages[i, 3 + c] = n[c], u[c]
        passages[i, 6] = (end - gap) / dt
        passages[i, 7] = 1.0 / w if w > 0.0 else 0.0
    return passages


@njit(cache=True, error_model="numpy")
def _solve(change, passages, masses, segments, fractions, friction):
    """Add the effect of impulses to the change of velocity, crossing by crossing, in place."""
    for _ in range(_SWEEPS):
        for i in range(len(segments)):  # The earliest first, on one thread: each sees those before it.
            mass = passages[i, 7]
            if mass == 0.0:
                continue
            n = (passages[i, 0], passages[i, 1], passages[i, 2])
            u = plus((passages[i, 3], passages[i, 4], passages[i, 5]), between(change, segments, fractions, i))
            dv = passages[i, 6] - dot(n, u)
            if dv > 1e-12 * np.sqrt(dot(u, u)):  # Less is rounding of u, and would mark points as struck that are not.
                apply(change, masses, segments, fractions, i, impulse(u, n, dv, friction, mass))
