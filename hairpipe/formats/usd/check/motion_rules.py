"""Rules for motion: velocities in units per second that agree with the points, in sums and for single strands."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hairpipe.formats.usd.check.scene import TINY, Fault, Scene, Snapshot, Track

MISFIT = 0.75  # largest relative difference of a step and its velocities, which are those of instants between
SLIGHT = 0.1  # of the usual step: smaller steps are ignored
EXACT = 0.015  # tolerance of the scale of all velocities, beyond their scatter
BELONG = 0.3  # least correlation of velocities with the displacement of the points
LATE = 0.25  # ratio of misfits from which velocities are those of another frame
ROUNDING = 64 * np.finfo(np.float32).eps  # of positions, in parts of the largest
WILD = (0.2, 5.0)  # accelerations over the change of the velocities
STILL = "are not 0, but points stand still"
WHY = "of another unit or frame, or the shape accelerates within the frame, as hair from rest in a wind does"
SCALE = (0.3, 3.0)  # the same of a single strand
JUMP = 0.5  # of its length: largest deviation of all points of a strand from the motion of its velocities
ALONE = 10.0  # times the usual deviation from which a strand jumps


def velocities_of_strands(track: Track) -> Iterator[Fault]:
    """Find strands with wrong velocities: 0 at one time or at all times, backwards, of another unit."""
    authored = both = seen = np.zeros(0)
    for before, now in _strands(track):
        lead = _lead(before, now)
        way = now.points.astype(np.float64) - before.points
        yield from _lost(track, before, way)
        authored = _add(authored, np.add.reduceat((lead**2).sum(axis=1), now.roots))
        both = _add(both, np.add.reduceat((lead * way).sum(axis=1), now.roots))
        seen = _add(seen, np.add.reduceat((way**2).sum(axis=1), now.roots))
    larger = np.maximum(authored, seen)
    minded = larger > SLIGHT**2 * np.median(larger) if len(larger) else larger > 0
    scale = np.sqrt(authored / np.maximum(seen, TINY))
    wrong = minded & ((both < BELONG * np.sqrt(authored * seen)) | (scale < SCALE[0]) | (scale > SCALE[1]))
    if wrong.any() and not wrong[minded].all():  # another rule reports all together
        at = int(np.argmax(wrong))
        turned = ", backwards" if both[at] < 0 else ""
        message = f"of strand {at} carry it {scale[at]:.2g} times as far as it goes{turned}"
        yield track.first.fault("velocities", f"{message}; {wrong.sum()} such strands")


def _lost(track: Track, hair: Snapshot, way: np.ndarray) -> Iterator[Fault]:
    """Find strands whose velocities are exactly 0 at a time at which they move, as the others do."""
    still = np.maximum.reduceat(np.abs(_velocities(hair)).max(axis=1), hair.roots) == 0.0
    far = np.add.reduceat(np.linalg.norm(way, axis=1), hair.roots)
    lost = still & (far > SLIGHT * np.median(far)) & (far > 0)
    if lost.any() and not still.all():
        yield hair.fault("velocities", f"of strand {np.argmax(lost)} are 0; {lost.sum()} such strands")


def strand_jumps(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find strands of which all points jump: to another strand, or to none."""
    for before, now in _strands(track):
        misses = now.points.astype(np.float64) - before.points - _lead(before, now)
        off = np.minimum.reduceat(np.linalg.norm(misses, axis=1), now.roots)
        usual = max(float(np.median(off)), TINY)
        jumped = (off > JUMP * before.lengths) & (off > ALONE * usual)
        if jumped.any():
            message = f"strand {np.argmax(jumped)} jumps by {off[np.argmax(jumped)]:.3g} from {before.code:g} on"
            yield track.fault("points", f"{message}; {jumped.sum()} such strands", now.code)


def _pairs(track: Track, *names: str) -> Iterator[tuple[Snapshot, Snapshot]]:
    """Yield consecutive samples of a take, with as many values of some attributes at both as points."""
    for before, now in pairwise(track.at(time) for time in track.points):
        arrays = [before.points, *(shape.array(name, 3) for shape in (before, now) for name in names)]
        if not track.is_cut(before, now) and all(a is not None and len(a) == len(now.points) for a in arrays):
            yield before, now


def _strands(track: Track) -> Iterator[tuple[Snapshot, Snapshot]]:
    """Yield pairs of samples, with velocities, that have the same valid strands."""
    for before, now in _pairs(track, "velocities"):
        is_finite = all(np.isfinite(_velocities(shape)).all() for shape in (before, now))
        if before.sound and now.sound and np.array_equal(before.counts, now.counts) and is_finite:
            yield before, now


def _velocities(shape: Snapshot) -> np.ndarray:
    return np.asarray(shape.array("velocities", 3), np.float64)


def _seconds(before: Snapshot, now: Snapshot) -> float:
    return (now.time.GetValue() - before.time.GetValue()) / now.prim.GetStage().GetTimeCodesPerSecond()


def _lead(before: Snapshot, now: Snapshot) -> np.ndarray:
    """Return the displacements by velocities from one sample to the next, (n, 3): (v0 + v1) / 2 dt."""
    return (_velocities(before) + _velocities(now)) / 2 * _seconds(before, now)


def _add(sums: np.ndarray, more: np.ndarray) -> np.ndarray:
    return sums + more if len(sums) == len(more) else more


class Sums(NamedTuple):
    """Products of displacements by authored velocities and of observed ones, summed over a shot."""

    authored: float
    both: float
    seen: float

    def add(self, authored: np.ndarray, seen: np.ndarray) -> "Sums":
        """Return the sums with two more arrays of one shape."""
        a = authored.ravel()
        b = seen.ravel()
        return Sums(self.authored + a @ a, self.both + a @ b, self.seen + b @ b)

    @property
    def scale(self) -> float:
        """Return the factor that fits authored to observed displacements."""
        return float(self.both / self.authored) if self.authored else 1.0

    @property
    def correlation(self) -> float:
        """Return the correlation of both, 1 for proportional ones."""
        product = np.sqrt(self.authored) * np.sqrt(self.seen)
        return float(self.both / product) if product else 1.0


NONE = Sums(0.0, 0.0, 0.0)


def velocity_match(scene: Scene) -> Iterator[Fault]:
    """Find velocities that do not agree with the motion of the points: of another unit, rate, sign or frame."""
    for track in [*scene.hair, *scene.meshes]:
        if track.moves and track.prim.GetAttribute("velocities").HasValue():
            message = next(_overall(track), "")
            if message:
                yield track.first.fault("velocities", f"{message}; units per second are right")
            elif steps := list(_step_by_step(track)):
                yield from steps
            elif track.first.curves:
                yield from velocities_of_strands(track)


def _overall(track: Track) -> Iterator[str]:
    """Report faults of the whole shot: x1 - x-1 = dt/3 (v-1 + 4 v0 + v1) to the fifth derivative (Simpson's rule)."""
    right, late, early = NONE, NONE, NONE
    authored_before = seen_before = None
    for (first, middle), (same, last) in pairwise(_pairs(track, "velocities")):
        dt = _seconds(first, middle)
        before, now, after = speeds = [_velocities(shape) for shape in (first, middle, last)]
        arrays = [*speeds, *(shape.points for shape in (first, middle, last))]
        is_even = middle is same and np.isclose(dt, _seconds(middle, last))
        if not is_even or not all(np.isfinite(array).all() for array in arrays):
            continue
        authored = dt / 3 * (before + 4 * now + after)
        seen = last.points.astype(np.float64) - first.points
        right = right.add(authored, seen)
        if authored_before is not None and seen_before is not None and len(authored_before) == len(authored):
            late = late.add(authored, seen_before)
            early = early.add(authored_before, seen)
        authored_before, seen_before = authored, seen
    noise = ROUNDING * np.sqrt(track.first.points.size) * np.abs(track.first.points).max(initial=0)
    if max(right.authored, right.seen) <= noise**2:
        return
    scatter = np.sqrt(max(0.0, 1 - right.correlation**2))
    near = min(1 - late.correlation, 1 - early.correlation) if late.authored else 1.0
    if near < LATE * (1 - right.correlation) and 1 - right.correlation > EXACT**2:
        yield f"are those of the frame {'before' if early.correlation > late.correlation else 'after'}"
    elif right.correlation < -BELONG:
        yield "point backwards"
    elif right.correlation < BELONG:
        yield "do not belong to these points"
    elif abs(right.scale - 1) > max(EXACT, scatter):
        yield f"are {np.sqrt(right.authored / max(right.seen, 1e-300)):.3g} times the motion of the points"


def _step_by_step(track: Track) -> Iterator[Fault]:
    """Find single samples with wrong velocities: (v0 + v1) / 2 = (x1 - x0) / (t1 - t0), up to the third derivative."""
    steps = list[tuple[float, float, float, float, float, float]]()
    for before, now in _pairs(track, "velocities"):
        arrays = [before.points, now.points, _velocities(before), _velocities(now)]
        sound = np.logical_and.reduce([np.isfinite(array).all(axis=1) for array in arrays])
        start, end = (shape.points[sound].astype(np.float64) for shape in (before, now))
        lead = _lead(before, now)[sound]
        way = end - start
        noise = ROUNDING * np.sqrt(start.size) * max(np.abs(start).max(initial=0), np.abs(end).max(initial=0))
        authored, seen, misfit = (float(np.linalg.norm(array)) for array in (lead, way, lead - way))
        steps.append((before.time.GetValue(), now.time.GetValue(), authored, seen, misfit, noise))
    usual = np.median([max(authored, seen) for _, _, authored, seen, _, _ in steps]) if steps else 0.0
    for code, after, authored, seen, misfit, noise in steps:
        larger = max(authored, seen)
        if misfit > max(MISFIT * larger, noise) and larger > SLIGHT * usual:
            text = f"are {authored / seen:.2g} times the motion of the points" if seen else STILL
            yield track.fault("velocities", f"{text} to {after:g}: {WHY}", code)


def velocities_missing(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find hair, and skin under it, that moves without velocities: motion blur separates them."""
    attribute = track.prim.GetAttribute("velocities")
    if track.moves and not attribute.HasValue():
        yield track.fault("velocities", "has no value; moving hair needs them, in units per second")
    elif not track.moves and attribute.HasValue():
        yield from _frozen(track)
    roots = scene.roots(track) if track.moves and attribute.HasValue() else None
    if roots and roots.mesh.moves and not roots.mesh.prim.GetAttribute("velocities").HasValue():
        message = f"has no value, while {track.prim.GetPath()} on it has; what moves together is blurred together"
        yield roots.mesh.fault("velocities", message)


def _frozen(track: Track) -> Iterator[Fault]:
    stage = track.prim.GetStage()
    hair = track.first
    speed = hair.array("velocities", 3)
    if not hair.sound or speed is None or not stage.GetEndTimeCode() > stage.GetStartTimeCode():
        return
    way = np.linalg.norm(speed, axis=1).max(initial=0) / stage.GetTimeCodesPerSecond()
    if way > EXACT * np.median(hair.lengths):
        span = f"{stage.GetStartTimeCode():g} to {stage.GetEndTimeCode():g}"
        yield hair.fault("points", f"has one value from {span}, but velocities that move it")


def acceleration_match(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find accelerations that contradict the velocities: (a0 + a1) / 2 = (v1 - v0) / dt."""
    sums = NONE
    moves = track.moves and track.prim.GetAttribute("accelerations").HasValue()
    for pair in _pairs(track, "velocities", "accelerations") if moves else ():
        a0, a1 = (np.nan_to_num(np.asarray(shape.array("accelerations", 3), np.float64)) for shape in pair)
        v0, v1 = (np.nan_to_num(_velocities(shape)) for shape in pair)
        sums = sums.add((a0 + a1) / 2 * _seconds(*pair), v1 - v0)
    if sums.seen > 0 and not (WILD[0] <= sums.scale <= WILD[1]):
        message = f"change the velocities {sums.authored**0.5 / sums.seen**0.5:.2g} times as much as they change"
        yield track.first.fault("accelerations", f"{message}; units per second squared are right")
