"""Goals as an interaction: of the whole groom by `[hair.goal]`, and of pinned points; the law is `laws/goal.py`.

A goal moves on the cubic through the places and velocities of two frames, as the clamps at the roots do
(`solve/boundary.py`).
"""
# pyright: reportCallIssue=false

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.rotations import root_frames
from hairpipe.geometry.triangle_tree import nearest_sites
from hairpipe.laws.goal import goal, goal_slope, spring_of
from hairpipe.laws.settings import Goal
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.solve.interactions import Interaction, Prediction, Start
from hairpipe.strands.hair_model import HairModel
from hairpipe.values import Groom, Mesh, Pins
from hairpipe.values.groom import Driver, fractions_along
from hairpipe.values.hair import HairState
from hairpipe.values.strand_arrays import members_of, name_strands
from hairpipe.values.triangles import Sites

_EQUAL = 1e-6
"""Relative difference of times that rounding may make."""


class Impulse:
    """Impulse of a force on every one of k points in a frame, summed as the integrators sum it.

    A stage x = xh + h v, v = vh + h f / m over a span s adds, to round-off,

        (s - h) f_ + h f

    where f is the force at its end and f_ what the scheme takes for it before: the force at the start of the step in
    the trapezoidal rule, h = s / 2; otherwise the mean force since the start of the step, or over the last step where
    the stage begins with the step (BDF2). Backward Euler, h = s, has no such part. We neglect that corrections after
    the solves move hair between steps.

    last_solve_only  whether the last solve of a step makes all of its velocity: the nine steps
    """

    def __init__(self, count: int) -> None:
        """Begin a frame without impulse."""
        self.last_solve_only = False
        self._frame, self._step = np.zeros((2, count, 3))
        self._force = self._mean = self._step
        self._time = self._dt = 0.0

    @property
    def total(self) -> np.ndarray:
        """The impulse since the frame began [N s], (k, 3)."""
        return self._frame + self._step

    def begin(self, force: np.ndarray, time: float, dt: float) -> None:
        """Begin a step of dt [s] at a time since the frame [s], where the force [N] is (k, 3)."""
        self._frame = self.total
        self._mean = self._step / self._dt if self._dt else force
        self._step = np.zeros_like(force)
        self._force, self._time, self._dt = force, time, dt
        self._stage, self._began = np.nan, self._step

    def add(self, force: np.ndarray, weights: np.ndarray, active: np.ndarray, time: float, span: float) -> None:
        """Add a stage that ends at a time with a force [N], (k, 3).

        weights, active  weight of the end [s], and whether its strand was solved now, (k,): otherwise nothing changes
        span             duration of the stage [s]
        """
        if self.last_solve_only:
            self._step = np.where(active[:, None], self._dt * force, self._step)
            return
        if time != self._stage:
            self._stage, self._began = time, self._step.copy()
        before = time - span - self._time
        trapezoid = (np.abs(2.0 * weights - span) < _EQUAL * span)[:, None]
        if before < _EQUAL * self._dt:
            began = np.zeros_like(force)
            earlier = np.where(trapezoid, self._force, self._mean)
        else:
            began = self._began
            earlier = began / before
        end = weights[:, None]
        self._step = np.where(active[:, None], began + (span - end) * earlier + end * force, self._step)


class Springs(NamedTuple):
    """Springs of some points: their indices, (k,) int64, stiffness [N/m] and damping [kg/s], (k,)."""

    points: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray


class Path(NamedTuple):
    """Places of goals between two frames: motions of rest points.

    owners              motion of every goal, (k,) int64
    rest                its point at rest [m], (k, 3)
    start, start_rate   motions x -> R x + t at the first frame, and their rates, (n, 3, 4)
    end, end_rate       the same at the second
    frame_dt            time between the frames [s]
    """

    owners: np.ndarray
    rest: np.ndarray
    start: np.ndarray
    start_rate: np.ndarray
    end: np.ndarray
    end_rate: np.ndarray
    frame_dt: float

    def motions(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return all motions at a time since the first frame [s] and their rates, on the cubic, (n, 3, 4)."""
        dt = self.frame_dt
        s = time / dt

        def blend(a: float, b: float, c: float, d: float) -> np.ndarray:
            return a * self.start + b * dt * self.start_rate + c * self.end + d * dt * self.end_rate

        place = blend((1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2, s**2 * (3 - 2 * s), s**2 * (s - 1))
        slope = blend(6 * s * (s - 1), (1 - s) * (1 - 3 * s), 6 * s * (1 - s), s * (3 * s - 2))
        return place, slope / dt


@dataclass(eq=False)
class GoalPull(Interaction):
    """Goals of some points of hair in a frame.

    springs  springs to the goals
    path     places of the goals
    strands  strand of every point of hair, (P,)
    """

    springs: Springs
    path: Path
    strands: np.ndarray

    def __post_init__(self) -> None:
        self._impulse = Impulse(len(self.springs.points))

    def begin(self, start: Start) -> None:
        """Begin to sum the impulse of a step."""
        force = self.force(start.points, start.velocities, start.time)
        self._impulse.begin(force, start.time, start.dt)

    def leave_to_corrections(self) -> None:
        """Sum the impulse as the nine steps do, whose last solve alone makes velocities."""
        self._impulse.last_solve_only = True

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the forces of the goals at the end of a stage, in place."""
        _add_pull(at, self.springs, self.path.owners, self.path.rest, *self.path.motions(at.time), push, damping)

    def judge(self, at: Prediction, again: np.ndarray) -> None:
        """Note the force at the end of a stage that has been solved."""
        points = self.springs.points
        force = self.force(at.points, at.velocities, at.time)
        free = at.active[points] & np.isfinite(at.masses[points])  # Held points are moved by their clamps.
        self._impulse.add(force, at.weights[points], free, at.time, at.span)

    def force(self, points: np.ndarray, velocities: np.ndarray, time: float) -> np.ndarray:
        """Return the forces of the goals [N], (k, 3), on hair at points [m] with velocities [m/s], (P, 3)."""
        force = np.empty((len(self.springs.points), 3))
        place, rate = self.path.motions(time)
        _find_force(points, velocities, self.springs, self.path.owners, self.path.rest, place, rate, force)
        return force

    def remember(self, state: HairState) -> HairState:
        """Return the state with the impulses of these goals in this frame, added to those of others; pure."""
        strands = self.strands[self.springs.points]
        count = self.strands[-1] + 1
        total = self._impulse.total
        own = np.stack([np.bincount(strands, total[:, c], count) for c in range(3)], axis=1)
        return replace(state, impulses=own if state.impulses is None else state.impulses + own)


@inlined
def _moved(motion, rest, i, c):
    """Return component c of rest point i under a motion (3, 4)."""
    return motion[c, 0] * rest[i, 0] + motion[c, 1] * rest[i, 1] + motion[c, 2] * rest[i, 2] + motion[c, 3]


@njit(cache=True, parallel=True)
def _add_pull(at, springs, owners, rest, place, rate, push, damping):
    """Add push - damping v of the goals on active points, in place; the points are distinct."""
    for i in prange(len(springs.points)):
        k = springs.points[i]
        if at.active[k]:
            h, stiffness, d = at.weights[k], springs.stiffness[i], springs.damping[i]
            for c in range(3):
                away = _moved(place[owners[i]], rest, i, c) - at.points[k, c]
                ahead = away + h * at.velocities[k, c]  # of a point that does not move: damping is as of `goal_slope`
                push[k, c] += goal(stiffness, d, ahead, _moved(rate[owners[i]], rest, i, c))
            for diagonal in (0, 3, 5):
                damping[k, diagonal] += goal_slope(stiffness, d, h)


@njit(cache=True, parallel=True)
def _find_force(points, velocities, springs, owners, rest, place, rate, force):
    """Set the forces of the goals, (k, 3), in place."""
    for i in prange(len(springs.points)):
        k = springs.points[i]
        for c in range(3):
            away = _moved(place[owners[i]], rest, i, c) - points[k, c]
            slip = _moved(rate[owners[i]], rest, i, c) - velocities[k, c]
            force[i, c] = goal(springs.stiffness[i], springs.damping[i], away, slip)


def goals_of(
    hair: HairModel,
    drivers: tuple[Driver, Driver],
    pins: Sequence[tuple[Pins, Pins]],
    goal: Goal | None,
    frame_dt: float,
) -> list[GoalPull]:
    """Return the goals of strands between two frames, frame_dt [s] apart.

    drivers  drivers of the roots of these strands at both frames
    pins     pins at both frames, of all strands, also where these are some of them

    Raises BadInput as `frequencies_of` and `check_pins`.
    """
    if goal is None and not pins:
        return []
    strands = np.repeat(np.arange(len(hair.groom.ids)), np.diff(hair.groom.offsets))
    found = []
    if goal is not None:
        frequency = frequencies_of(goal, hair)
        points = np.flatnonzero(frequency > 0.0)
        springs = _springs(points, hair.masses, frequency[points], goal.damping)
        ends = (motion_of_roots(driver, hair.groom) for driver in drivers)
        path = Path(strands[points], hair.groom.points[points], *(m for end in ends for m in end), frame_dt)
        found.append(GoalPull(springs, path, strands))
    for before, after in pins:
        check_pins(after, hair)
        points = after.points if hair.part_of is None else hair.part_of[1][after.points]
        kept = np.flatnonzero(points >= 0)
        points = points[kept]
        springs = _springs(points, hair.masses, np.full(len(points), after.frequency), after.damping)
        moves = (_shift(values[kept]) for end in (before, after) for values in (end.positions, end.velocities))
        path = Path(np.arange(len(points)), np.zeros((len(points), 3)), *moves, frame_dt)
        found.append(GoalPull(springs, path, strands))
    return found


def check_pins(pins: Pins, hair: HairModel) -> None:
    """Raise BadInput for pins of another groom."""
    whole = hair if hair.part_of is None else hair.part_of[0]
    if pins.among != len(whole.groom.points):
        what = f"pins of a groom of {pins.among} points, for one of {len(whole.groom.points)}"
        raise BadInput(what, where="in.pins", right="pin_hair of the groom that is simulated")


def frequencies_of(goal: Goal, hair: HairModel) -> np.ndarray:
    """Return the frequency of the goal at every point of hair [Hz], (P,); BadInput as `values_of`."""
    values = hair.values_of(goal.frequency, "goal.frequency")
    return np.broadcast_to(values, (2, len(hair.groom.points)))[0]


def _springs(points: np.ndarray, masses: np.ndarray, frequency: np.ndarray, damping: float) -> Springs:
    """Return springs of a frequency [Hz], (k,), and a ratio of damping at points, (k,); masses [kg] are of all."""
    return Springs(points.astype(np.int64), *spring_of(masses[points], frequency, damping))


def _shift(places: np.ndarray) -> np.ndarray:
    """Return the motions of nothing but the origin to places, or their rates, (k, 3): (k, 3, 4)."""
    motions = np.zeros((len(places), 3, 4))
    motions[:, :, 3] = places
    return motions


class Pinned(NamedTuple):
    """Pinned points of a groom: indices, (k,) int32, at rest [m], (k, 3), their sites, and the frames of those."""

    points: np.ndarray
    rest: np.ndarray
    sites: Sites
    frames: np.ndarray


def pin(
    groom: Groom,
    mesh: Mesh | None,
    group: str | None,
    at: tuple[float, ...],
    place: tuple[float, float, float] | None,
    reach: float,
) -> Pinned:
    """Bind points of a group of strands, or of all, to a mesh at rest, or without one to the roots of their strands.

    at     fractions of the length, at each of which the nearest point of a strand is pinned
    place  place whose nearest point of each strand is pinned [m]; without it or fractions, that nearest to the mesh
    reach  maximum distance of a pinned point from the mesh [m]

    Raises BadInput for an unknown group, where a strand is farther away, and if neither mesh nor fractions are given.
    """
    counts = np.diff(groom.offsets)
    members = np.ones(len(counts), bool) if group is None else members_of(groom, (group,), "group")
    strands = np.flatnonzero(members)
    if at:
        along = fractions_along(groom.points, groom.offsets)
        ranks = [np.abs(along - fraction) for fraction in at]
    elif place is not None:
        ranks = [np.linalg.norm(groom.points - np.array(place), axis=1)]
    elif mesh is not None:
        ranks = [nearest_sites(mesh, groom.points)[1]]
    else:
        raise BadInput(
            "nothing states which points are pinned", where="at", right="fractions of the length, a place, or in.rest"
        )
    points = np.unique([_lowest(rank, groom.offsets, strands) for rank in ranks]).astype(np.int32)
    owners = np.searchsorted(groom.offsets, points, side="right") - 1
    if mesh is None:
        sites = Sites(groom.root_triangles[owners], groom.root_barycentrics[owners])
        return Pinned(points, groom.points[points], sites, groom.root_frames[owners])
    sites, away = nearest_sites(mesh, groom.points[points])
    if (away > reach).any():
        named = name_strands(groom.ids[np.unique(owners[away > reach])])
        what = f"pinned points up to {away.max():.3g} m away from the body: {named}"
        raise BadInput(what, where="in.rest", right=f"every point within reach = {reach:g} m")
    return Pinned(points, groom.points[points], sites, root_frames(mesh.points, mesh.triangles, *sites))


def _lowest(rank: np.ndarray, offsets: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """Return the point of lowest rank, (P,), of each of some strands but its root, which is held already."""
    return np.array([offsets[s] + 1 + np.argmin(rank[offsets[s] + 1 : offsets[s + 1]]) for s in strands])


def check_mesh(pinned: Pinned, mesh: Mesh) -> None:
    """Raise BadInput where points are pinned to triangles that a mesh does not have."""
    bound = pinned.sites.triangles.max(initial=-1)
    if bound >= len(mesh.triangles):
        what = f"hair is pinned to triangle {bound} of a body that has {len(mesh.triangles)}"
        raise BadInput(what, where="in.body", right="the body of the roots, or in.rest moved")
