"""Hair against the body in one step: held while it is solved, caught where it ran into it, put right at the end.

Hair inside a body rises out of it slowly, so that the strand is neither stretched nor shaken.

A point that begins a step deeper than DEEP is not held at the surface, which may be out of reach of its root. It is
dragged by a viscous medium that rises by PUSH_OUT along the outward normal n,

    f = m r (w - v),   w = v_b + min(PUSH_OUT, (kept - phi) / dt) n,   r = (STRAIN E A / M) / PUSH_OUT

with E A the axial stiffness of the strand and M its mass: the total force never strains the strand by more than
STRAIN. The push is the gradient of a potential, r PUSH_OUT m times the depth, and motion in the medium is dissipated:
on a body at rest the energy of hair only falls. There is no friction. With a rigid constraint, an overlong strand
stored the work of the push in its springs and was thrown about: at 5 to 14 m/s, throughout the run.

The contact distance of a point is also limited by the point before it, `within_reach`: hair leaves the body from the
root on, and points that the root holds back are not pulled.

Hair in a narrow gap between bodies stays there, and does not jump from one body to the other.

A point at the distance phi < kept along the normal n would be moved out to x + (kept - phi) n. If a body opposes it
there, with a normal m.n < 0, at a distance b below the thickness d, the gap is kept + b instead of kept + d, and the
point takes its share of the gap:

    kept (kept + b) / (kept + d)

which is the middle where kept = d. Bodies that overlap have b < -kept: the point is then equally deep in both.

A cache of distances to bodies: only points whose answer may have changed are queried again.

Within a step points are queried many times: at the start, at the predicted and the computed end of each stage, and at
the end of the step. An unmoved point is not queried again at the same time, nor is a free point that cannot have come
near: distances change by at most STEEPEST times the way of the point relative to the bodies. That way is bounded by the
way in the world and the fastest speed of a body; where this does not suffice, each body bounds it: hair moves with the
head. The cached distance of such a point may have an error of that size; it is read only where the error is harmless.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.contact.body_implicit import (
    DEEP,
    FREE,
    INSIDE,
    PUSH_OUT,
    STIFF,
    TOUCHES,
    ContactState,
    hold,
    resume,
    stop_normals,
    update_active_set,
)
from hairpipe.contact.body_projection import Motion, drape, farthest, project
from hairpipe.contact.contact_points import USUAL, Scale, scale_of
from hairpipe.geometry.collider import STEEPEST, Collider, FirstHit, SdfSample, Walk, Wander
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.sorting import places_of, rows_at
from hairpipe.geometry.vec3 import length, minus, row
from hairpipe.laws.fold_preservation import Turns, add_heights, turns_of
from hairpipe.laws.settings import BodyContact
from hairpipe.solve.interactions import Interaction, Prediction, Start, StepEnd
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.interface import StrandModel
from hairpipe.values.hair import HairState, Touching
from hairpipe.values.strand_arrays import thicknesses

STRAIN = 5e-3
"""Largest stretch of a strand by the push on all its points."""
LEAST = 50.0
"""The push is as strong as that, at least [m/s^2]: hair that its weight alone strains by more must come out, too."""
_REACH = 0.8
"""Largest difference in distance of consecutive points, over their segment."""
_CHUNK = 512


def pushes(axial: np.ndarray, masses: np.ndarray, offsets: np.ndarray, scale: Scale = USUAL) -> np.ndarray:
    """Return the acceleration that pushes points [m/s^2], (P,); pure."""
    total = np.add.reduceat(np.where(np.isfinite(masses), masses, 0.0), offsets[:-1])
    push = np.divide(STRAIN * axial, total, out=np.zeros_like(axial), where=total > 0.0)
    return np.repeat(np.maximum(push, LEAST * scale.speed / scale.time), np.diff(offsets))


def within_reach(start_distance: np.ndarray, segments: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the largest contact distances of points in a step, limited by the points before them [m], (P,); pure."""
    reach = np.roll(start_distance, 1) + _REACH * segments
    reach[offsets[:-1]] = np.inf
    return reach


@njit(cache=True, parallel=True)
def rise(
    contact: ContactState, probe: SdfSample, kept: np.ndarray, push: np.ndarray, mass: np.ndarray, dt: float
) -> None:
    """Mark the points that rise in a step of dt [s], which begin it deep inside, in place; the others become free.

    probe  probe of the body at the points
    kept   contact distance [m], (P,)
    push   [m/s^2], (P,); mass  [kg], (P,), inf: held by the root
    """
    deep, speed = DEEP * contact.length, PUSH_OUT * contact.speed
    for chunk in prange((len(push) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(push))):
            if probe.distance[i] < -deep and mass[i] < np.inf:
                _rise(contact, probe, i, kept[i], push[i] / speed * mass[i], speed, dt)
            elif contact.state[i] == INSIDE:  # Out now: from here on an ordinary contact holds it.
                _release(contact, i)


@inlined
def _release(contact, i):
    contact.discontinuous[i] = True
    contact.state[i] = FREE


@inlined
def _rise(contact, probe, i, kept, damping, fastest, dt):
    nx, ny, nz = probe.normal[i, 0], probe.normal[i, 1], probe.normal[i, 2]
    vx, vy, vz = probe.velocity[i, 0], probe.velocity[i, 1], probe.velocity[i, 2]
    speed = min(fastest, max(kept - probe.distance[i], 0.0) / dt)
    contact.discontinuous[i] |= contact.state[i] != INSIDE
    contact.state[i] = INSIDE
    contact.c_t[i] = contact.c_n[i] = damping  # Isotropic, as in a thick fluid: no surface, and no friction.
    contact.body[i] = vx * nx + vy * ny + vz * nz
    contact.normal[i, 0], contact.normal[i, 1], contact.normal[i, 2] = nx, ny, nz
    contact.target[i, 0], contact.target[i, 1], contact.target[i, 2] = vx + speed * nx, vy + speed * ny, vz + speed * nz


_PUSHED = 1e-4  # [m]; points that are moved out by less are not looked at
_AGAINST = -0.5  # cosine between normals


def share_gap(
    points: np.ndarray,
    time: float,
    surfaces: Sequence[Collider],
    probe: SdfSample,
    thickness: np.ndarray,
    kept: np.ndarray,
    scale: float = 1.0,
) -> np.ndarray:
    """Return the contact distances of points [m], (P,), reduced in narrow gaps between bodies; pure."""
    is_pushed = np.empty(len(points), np.bool_)
    _mark_pushed(probe, kept, scale * _PUSHED, is_pushed)
    pushed = places_of(is_pushed)
    if not len(pushed):
        return kept
    target_gap = kept[pushed]
    normals = probe.normal[pushed]
    ahead = SdfSample.blank(len(pushed), float(thickness.max(initial=0.0)))
    for surface in surfaces:
        surface.probe(points[pushed] + (target_gap - probe.distance[pushed])[:, None] * normals, time, ahead)
    against = np.einsum("pc,pc->p", ahead.normal, normals) < _AGAINST
    room = target_gap + np.minimum(ahead.distance, thickness[pushed])
    out = kept.copy()
    share = target_gap / np.maximum(target_gap + thickness[pushed], scale * _PUSHED)
    out[pushed[against]] = (share * room)[against]
    return out


@njit(cache=True, parallel=True)
def _mark_pushed(probe, kept, least, marked):
    """Mark points that are moved out along a normal by more than the least [m], (P,) bool, in place."""
    for i in prange(len(kept)):
        n = probe.normal[i]
        marked[i] = probe.distance[i] < kept[i] - least and (n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0)


_MANY = 4096
"""Points for which it pays to ask bodies for their ways: each time they find the poses of their parts."""


@dataclass(eq=False)
class ProbeCache:
    """The last result for every point, of bodies as one.

    reach      distance beyond which bound points get the distance only [m]
    far        distance beyond which free points get the distance only, which is not used [m]
    probe      last results, changed in place
    clearance  lower bound of the distance where the point is now [m], (P,); exact up to `far`
    """

    surfaces: Sequence[Collider]
    count: int
    reach: float
    far: float
    probe: SdfSample = field(init=False)
    clearance: np.ndarray = field(init=False)
    _band: float = field(init=False)
    _speed: float = field(init=False)
    _seen: "_Seen" = field(init=False)
    _last: float = field(default=np.nan, init=False)

    def __post_init__(self) -> None:
        self._band = min((surface.band for surface in self.surfaces), default=np.inf)
        self._speed = max((surface.speed for surface in self.surfaces), default=0.0)
        self.probe = SdfSample.blank(self.count, self._band)
        self.clearance = np.full(self.count, np.nan)
        places = np.full((self.count, 3), np.nan)
        times = np.full(self.count, np.nan)
        self._seen = _Seen(places, times, np.zeros(self.count, np.bool_), self.clearance)

    def renew(self, points: np.ndarray, time: float, active: np.ndarray, bound: np.ndarray) -> None:
        """Query the bodies at points [m], (P, 3), at a time since the previous frame [s].

        active  points to query, (P,) bool; the others keep their last results, of any position and time
        bound   points bound to a body at any distance: queried if they have moved, (P,) bool
        """
        unsure = np.empty(self.count, np.bool_)
        _find_unsure(points, time, self._seen, active, bound, (self.far, self._speed), unsure)
        again = places_of(unsure)
        if len(again) >= _MANY and self._last < np.inf:
            ways = np.zeros(len(again))
            wander = Wander(self._seen.places, self._last, points, time, again)
            for surface in self.surfaces:
                surface.approach(wander, ways)
            _leave_out(wander, ways, self._seen, bound, self.far, unsure)
            again = places_of(unsure)
        self._last = time
        if len(again):
            places = rows_at(points, again)
            some = SdfSample.blank(len(again), self._band)
            reach = np.where(bound[again], self.reach, self.far)
            for surface in self.surfaces:
                surface.probe(places, time, some, reach)
            _note_all(self._seen, points, time, again, some.distance)
            _put(some, again, *self.probe)


class _Seen(NamedTuple):
    """Where points were last [m], (P, 3), when [s], whether they were queried there, and lower bounds [m], (P,)."""

    places: np.ndarray
    times: np.ndarray
    is_exact: np.ndarray
    clearance: np.ndarray


@njit(cache=True, parallel=True)
def _find_unsure(points, time, seen, active, bound, law, unsure):
    """Mark active points whose answers may differ from those seen, (P,) bool, and bound the others, in place."""
    far, speed = law
    for i in prange(len(points)):
        unsure[i] = False
        if active[i]:
            way = length(minus(row(points, i), row(seen.places, i))) + speed * abs(time - seen.times[i])
            if not (way == 0.0 and time == seen.times[i] and seen.is_exact[i]):
                unsure[i] = bound[i] or not _stays_far(seen, points, time, i, way, far)


@njit(cache=True, parallel=True)
def _leave_out(wander, ways, seen, bound, far, unsure):
    """Take the marks from points that have not come near by ways relative to the bodies [m], (n,), in place."""
    for k in prange(len(ways)):
        i = wander.which[k]
        if seen.times[i] == wander.then and not bound[i]:
            unsure[i] = not _stays_far(seen, wander.after, wander.now, i, ways[k], far)


@inlined
def _stays_far(seen, points, time, i, way, far):
    """Whether point i cannot have come nearer than far by a way: nobody reads its exact distance."""
    least = seen.clearance[i] - STEEPEST * way
    if least > far:
        _note(seen, points, time, i, least)
        seen.is_exact[i] = False
    return least > far


@inlined
def _note(seen, points, time, i, least):
    """Write down where and when point i is, with a lower bound of its distance [m], in place."""
    seen.times[i] = time
    seen.clearance[i] = least
    seen.is_exact[i] = True
    for c in range(3):
        seen.places[i, c] = points[i, c]


@njit(cache=True, parallel=True)
def _note_all(seen, points, time, which, distance):
    """Write down where and when points, (n,), were queried, with their distances [m], (n,), in place."""
    for k in prange(len(which)):
        _note(seen, points, time, which[k], distance[k])


@njit(cache=True, parallel=True)
def _put(some, which, distance, normal, velocity):
    """Write the answers for some points, (n,), to those for all, a SdfSample, unpacked; in place."""
    for k in prange(len(which)):
        i = which[k]
        distance[i] = some.distance[k]
        for c in range(3):
            normal[i, c], velocity[i, c] = some.normal[k, c], some.velocity[k, c]


_PARTS = 8  # of a step, that the normals are read at where hair ran into something
_MARGIN = 5e-3  # [m]; points farther than this beyond their thickness are not looked at, nor held
_SUNK = 1e-5  # [m]; points that the solves hold are not moved out where they sank in by less
_NEAR = 1e-4  # [m]; what is farther than this beyond it begins to touch in no case


@dataclass(eq=False)
class BodyContacts(Interaction):
    """Contact with bodies within a frame; contact states persist from stage to stage, and from frame to frame.

    surfaces   the bodies, as one level set
    thickness  contact distance of points [m], (P,)
    offsets    offsets of the points of strands, (S+1,) int32
    segments   lengths from the points to the previous points [m], (P,)
    axial      E A of the strands [N], (S,)
    turns      turns of curls that keep their shape; None: curls are pressed flat
    scale      factors on lengths and speeds of the tolerances
    known      contact at the end of the previous frame; None: unknown
    """

    surfaces: list[Collider]
    contact: BodyContact
    thickness: np.ndarray
    offsets: np.ndarray
    segments: np.ndarray
    axial: np.ndarray
    turns: Turns | None = None
    scale: Scale = USUAL
    known: Touching | None = None
    _state: ContactState = field(init=False)
    _cache: ProbeCache = field(init=False)
    _everyone: np.ndarray = field(init=False)
    _start_distance: np.ndarray = field(init=False)
    _target_gap: np.ndarray = field(init=False)
    _kept: np.ndarray = field(init=False)
    _reach: np.ndarray = field(init=False)
    _is_left_to_corrections: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        self._state = ContactState.none(len(self.thickness), self.scale)
        if self.known is not None:
            self._state.recall(self.known)
        self._everyone = np.ones(len(self.thickness), np.bool_)
        highest = 2.0 * self.turns.radii.max(initial=0.0) if self.turns is not None else 0.0
        far = float(self.thickness.max(initial=0.0) + highest)
        self._reach = np.full(len(self.thickness), np.inf)
        margin, near = _MARGIN * self.scale.length, _NEAR * self.scale.length
        self._cache = ProbeCache(self.surfaces, len(self.thickness), far + margin, far + near)

    def look(self, points: np.ndarray, time: float, active: np.ndarray) -> SdfSample:
        """Query the body at a time since the previous frame [s], and the contact distances of points there.

        active  points to query, (P,) bool; the others keep their last result
        """
        self._cache.renew(points, time, active, self._state.state != FREE)
        probe = self._cache.probe
        self._target_gap = self.thickness
        if self.turns is not None and self.contact.folds is not None:
            self._target_gap = self.thickness.copy()
            add_heights(points, self.offsets, self.turns, probe.normal, self.contact.folds, self._target_gap)
        gaps = self.thickness, self._target_gap
        room = share_gap(points, time, self.surfaces, probe, *gaps, self.scale.length)
        self._kept = np.empty_like(room)
        _take_lower(room, self._reach, self._kept)
        return probe

    def begin(self, start: Start) -> None:
        """Note where points begin a step, and how fast."""
        if self._is_left_to_corrections:
            self._let_go()
            self._is_left_to_corrections = False
        masses = start.masses
        self._reach = np.full(len(masses), np.inf)
        probe = self.look(start.points, start.time, self._everyone)
        self._start_distance = self._cache.clearance.copy()
        self._reach = within_reach(self._start_distance, self.segments, self.offsets)
        _take_lower(self._kept, self._reach, self._kept)
        self._state.discontinuous[:] = False
        push = pushes(self.axial, masses, self.offsets, self.scale)
        rise(self._state, probe, self._kept, push, masses, start.dt)
        resume(self._state, probe, start.velocities, self._kept, masses)

    def leave_to_corrections(self) -> None:
        """Hold nothing in the solves of this step but what rises, and what `correct` finds."""
        self._is_left_to_corrections = True
        self._let_go()

    def _let_go(self) -> None:
        """Hold nothing but what rises, until points are looked at again."""
        self._state.state[self._state.state != INSIDE] = FREE

    def predict(self, at: Prediction) -> None:
        """Probe the predicted positions of active points at the end of a stage."""
        if not self._is_left_to_corrections:
            self.look(at.points, at.time, at.active)
            self._state.freed[:] = False

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the forces that hold points, push - damping v, in place; see `hold`."""
        hold(self._state, self._cache.probe, at, self._kept, push, damping, not self._is_left_to_corrections)

    def judge(self, at: Prediction, again: np.ndarray) -> None:
        """Probe the result of a solve; mark points whose contact changed, (P,) bool, in place."""
        if not self._is_left_to_corrections:
            probe = self.look(at.points, at.time, at.active)
            changed = np.empty(len(at.points), np.bool_)
            update_active_set(self._state, probe, at, self._kept, self.contact.friction, changed)
            np.logical_or(again, changed, out=again)

    def mark_discontinuous(self, marked: np.ndarray) -> None:
        """Mark points whose contact jumped in this step, or that were moved out at the end, (P,) bool, in place."""
        np.logical_or(marked, self._state.discontinuous, out=marked)

    def remember(self, state: HairState) -> HairState:
        """Return the state at the end of a frame with what points touch; nothing is asked of this object afterwards."""
        if self._is_left_to_corrections:
            self._let_go()  # As the next step would.
        return replace(state, touching=self._state.touching())

    @property
    def speed_bound(self) -> float:
        """Speed that no body exceeds [m/s]."""
        return max((surface.speed for surface in self.surfaces), default=0.0)

    def finish_solves(self, end: StepEnd) -> None:
        """Set the normal velocity of held points to that of the body: contact is inelastic."""
        velocities = end.velocities
        change = np.empty_like(velocities)
        stop_normals(self._state, velocities, self._cache.probe.distance, change)
        end.push(change)

    def _hold_normals(self, active: np.ndarray, normals: np.ndarray, masses: np.ndarray, dt: float) -> None:
        """Prescribe the body's normal velocity to active points, (P,) bool, in the next solves; release the others.

        As in the paper's velocity solve, in a step of dt [s]; friction acts before it.
        """
        contact = self._state
        others = contact.state != INSIDE
        contact.state[others] = np.where(active & np.isfinite(masses), TOUCHES, FREE)[others]
        contact.c_t[others] = 0.0
        contact.normal[others] = normals[others]
        contact.target[others] = self._cache.probe.velocity[others]
        contact.c_n[others] = np.where(contact.state == TOUCHES, STIFF * masses / dt, 0.0)[others]

    def correct(self, end: StepEnd) -> None:
        """Move points out of the body, and slow them down, in place."""
        before, after, velocities, masses = end.points_before, end.points, end.velocities, end.masses
        ended = self.look(after, end.time + end.dt, self._everyone)
        walk = Walk(before, after, self.thickness, self._start_distance, self._cache.clearance)
        hits = FirstHit.blank(len(after))
        for surface in self.surfaces:
            surface.sweep(walk, end.time, end.time + end.dt, hits)
        met = np.flatnonzero((hits.fraction <= 1.0) & np.isfinite(masses))
        parts = np.minimum((hits.fraction[met] * _PARTS).astype(int), _PARTS - 1)
        meeting = self._meeting(end, before[met], after[met], parts)
        leaving = SdfSample.blank(len(met))
        for surface in self.surfaces:
            surface.probe(after[met], end.time + end.dt, leaving)
        most = farthest(self._start_distance, end.dt, self.scale)
        # What the solves hold has sunk in by its load: moved out, it would recoil in the next step, and tremble.
        kept = np.where(self._state.state == TOUCHES, self._kept - _SUNK * self.scale.length, self._kept)
        motion = Motion(before, after, velocities, most, kept, masses, end.dt, self.contact.friction)
        dx, dv, touched, normals = project(motion, ended, met, parts / _PARTS, meeting, leaving.normal)
        # What is pressed on the body sinks in and is moved out in every step: with the forces found before it trembles.
        np.logical_or(self._state.discontinuous, touched, out=self._state.discontinuous)
        which = self._points_to_drape(touched)
        draped, directions = dx[which], normals[which]

        def look(places: np.ndarray, chosen: np.ndarray) -> tuple[SdfSample, np.ndarray]:
            return self._around(places, which[chosen], end.time + end.dt)

        if len(which):
            drape(after[which], draped, directions, most[which], masses[which], look, self.scale.length)
        dx[which], normals[which] = draped, directions
        end.move(dx)
        end.push(dv)
        if self._is_left_to_corrections:
            self._hold_normals(touched, normals, masses, end.dt)

    def _points_to_drape(self, touched: np.ndarray) -> np.ndarray:
        """Find all points of strands with touched points, (P,) bool: their indices, (n,)."""
        strands = np.searchsorted(self.offsets, np.flatnonzero(touched), side="right") - 1
        chosen = np.zeros(len(self.offsets) - 1, np.bool_)
        chosen[strands] = True
        return np.flatnonzero(np.repeat(chosen, np.diff(self.offsets)))

    def _meeting(self, end: StepEnd, before: np.ndarray, after: np.ndarray, parts: np.ndarray) -> SdfSample:
        """Find the body where and when points that run into it have not yet: after so many parts of the step, (n,)."""
        meeting = SdfSample.blank(len(parts))
        for part in np.unique(parts):
            chosen = parts == part
            share = part / _PARTS
            at = before[chosen] + share * (after[chosen] - before[chosen])
            found = SdfSample.blank(len(at))
            for surface in self.surfaces:
                surface.probe(at, end.time + share * end.dt, found)
            for target, values in zip(meeting, found, strict=True):
                target[chosen] = values
        return meeting

    def _around(self, places: np.ndarray, which: np.ndarray, time: float) -> tuple[SdfSample, np.ndarray]:
        """Find the body at places [m], (n, 3), of points (n,), and what these keep from it there [m], (n,)."""
        target_gap = self._target_gap[which]
        probe = SdfSample.blank(len(places), float(target_gap.max(initial=0.0)) + _MARGIN * self.scale.length)
        for surface in self.surfaces:
            surface.probe(places, time, probe)
        room = share_gap(places, time, self.surfaces, probe, self.thickness[which], target_gap, self.scale.length)
        return probe, np.minimum(room, self._reach[which])


@njit(cache=True, parallel=True)
def _take_lower(first, second, out):
    """Set out to the lower of two numbers at every point, (P,), in place."""
    for i in prange(len(out)):
        is_first = first[i] < second[i] or np.isnan(first[i])  # What is not finite stays so, as in np.minimum.
        out[i] = first[i] if is_first else second[i]


def body_contacts_of(
    hair: HairModel,
    model: StrandModel,
    touching: Touching | None,
    bodies: Sequence[Collider],
    contact: BodyContact,
    gravity: float,
) -> BodyContacts:
    """Make what holds hair out of bodies; touching  what it touched at the end of the previous frame."""
    points, offsets = hair.groom.points, hair.layout.offsets
    turns = turns_of(points, offsets) if contact.folds is not None else None
    axial = np.empty(len(offsets) - 1)
    axial[hair.layout.strands] = model.constants[model.first[:-1], 0]
    segments = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    kept = thicknesses(offsets, contact.thickness)
    scale = scale_of(max(contact.thickness, hair.diameter), BodyContact().thickness, gravity)
    return BodyContacts(list(bodies), contact, kept, offsets, segments, axial, turns, scale, touching)
