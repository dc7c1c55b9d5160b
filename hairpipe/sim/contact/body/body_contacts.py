"""Hair against the body in one step: held while it is solved, caught where it ran into it, put right at the end."""

from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit, prange

from hairpipe.data.hair import HairState, Touching
from hairpipe.levelset.collider import Collider, FirstHit, SdfSample, Walk
from hairpipe.sim.contact.body.depenetration import pushes, rise, within_reach
from hairpipe.sim.contact.body.fold_preservation import Turns, add_heights
from hairpipe.sim.contact.body.implicit import (
    FREE,
    INSIDE,
    STIFF,
    TOUCHES,
    ContactState,
    hold,
    resume,
    stop_normals,
    update_active_set,
)
from hairpipe.sim.contact.body.length_projection import drape
from hairpipe.sim.contact.body.pinching import share_gap
from hairpipe.sim.contact.body.probe_cache import ProbeCache
from hairpipe.sim.contact.body.projection import Motion, farthest, project
from hairpipe.sim.contact.scale import USUAL, Scale
from hairpipe.sim.interactions import Interaction, Prediction, Start, StepEnd
from hairpipe.sim.settings import BodyContact

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
        if self._is_left_to_corrections:
            at = at._replace(active=np.zeros_like(at.active))
        hold(self._state, self._cache.probe, at, self._kept, push, damping)

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
