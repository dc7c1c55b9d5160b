"""Rules for the motion of single strands, which are invisible in sums over all strands."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Scene, Snapshot, Track

SLIGHT = 0.1  # of the median displacement: slower strands are ignored
BELONG = 0.3  # least correlation and scale of velocities with the displacement of a strand
SCALE = (0.3, 3.0)
JUMP = 0.5  # of its length: largest deviation of all points of a strand from the motion of its velocities
ALONE = 10.0  # times the usual deviation from which a strand jumps
TINY = np.finfo(np.float64).tiny


def velocities_of_strands(track: Track) -> Iterator[Fault]:
    """Find strands with wrong velocities: 0 at one time or at all times, backwards, of another unit."""
    authored = both = seen = np.zeros(0)
    for before, now in _steps(track):
        lead = _lead(before, now)
        way = now.points.astype(np.float64) - before.points
        yield from _lost(track, before, way)
        authored = _add(authored, now.per_strand_of_points((lead**2).sum(axis=1)))
        both = _add(both, now.per_strand_of_points((lead * way).sum(axis=1)))
        seen = _add(seen, now.per_strand_of_points((way**2).sum(axis=1)))
    larger = np.maximum(authored, seen)
    minded = larger > SLIGHT**2 * np.median(larger) if len(larger) else larger > 0
    scale = np.sqrt(authored / np.maximum(seen, TINY))
    wrong = minded & ((both < BELONG * np.sqrt(authored * seen)) | (scale < SCALE[0]) | (scale > SCALE[1]))
    if wrong.any() and not wrong[minded].all():  # another rule reports all together
        at = int(np.argmax(wrong))
        turned = ", backwards" if both[at] < 0 else ""
        message = f"of strand {at} carry it {scale[at]:.2g} times as far as it goes{turned}"
        yield Fault(track.path("velocities"), f"{message}; {wrong.sum()} such strands", track.first.code)


def _lost(track: Track, hair: Snapshot, way: np.ndarray) -> Iterator[Fault]:
    """Find strands whose velocities are exactly 0 at a time at which they move, as the others do."""
    speeds = np.abs(np.asarray(hair.array("velocities", 3))).max(axis=1)
    still = np.maximum.reduceat(speeds, hair.roots) == 0.0
    far = hair.per_strand_of_points(np.linalg.norm(way, axis=1))
    lost = still & (far > SLIGHT * np.median(far)) & (far > 0)
    if lost.any() and not still.all():
        yield Fault(
            track.path("velocities"), f"of strand {np.argmax(lost)} are 0; {lost.sum()} such strands", hair.code
        )


def strand_jumps(scene: Scene) -> Iterator[Fault]:
    """Find strands of which all points jump: to another strand, or to none."""
    for track in scene.hair:
        for before, now in _steps(track):
            off = now.nearest_of_points(_misses(before, now))
            usual = max(float(np.median(off)), TINY)
            jumped = (off > JUMP * before.lengths) & (off > ALONE * usual)
            if jumped.any():
                message = f"strand {np.argmax(jumped)} jumps by {off[np.argmax(jumped)]:.3g} from {before.code:g} on"
                yield Fault(track.path("points"), f"{message}; {jumped.sum()} such strands", now.code)


def _steps(track: Track) -> Iterator[tuple[Snapshot, Snapshot]]:
    """Yield pairs of consecutive samples of the same valid strands, with velocities at both."""
    for before, now in pairwise(track.at(time) for time in track.points):
        arrays = [shape.array("velocities", 3) for shape in (before, now)]
        whole = before.sound and now.sound and np.array_equal(before.counts, now.counts)
        if (
            whole
            and not track.is_cut(before, now)
            and all(a is not None and len(a) == len(now.points) and np.isfinite(a).all() for a in arrays)
        ):
            yield before, now


def _lead(before: Snapshot, now: Snapshot) -> np.ndarray:
    """Return the displacements by velocities from one sample to the next, (n, 3): (v0 + v1) / 2 dt."""
    speeds = [np.asarray(shape.array("velocities", 3), np.float64) for shape in (before, now)]
    rate = before.prim.GetStage().GetTimeCodesPerSecond()
    return (speeds[0] + speeds[1]) / 2 * (now.time.GetValue() - before.time.GetValue()) / rate


def _misses(before: Snapshot, now: Snapshot) -> np.ndarray:
    """Return the distances of points from their displacement by velocities, (n,)."""
    return np.linalg.norm(now.points.astype(np.float64) - before.points - _lead(before, now), axis=1)


def _add(sums: np.ndarray, more: np.ndarray) -> np.ndarray:
    return sums + more if len(sums) == len(more) else more


RULES = (Rule("strand-jumps", "error", strand_jumps),)
