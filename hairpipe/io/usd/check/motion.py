"""Rules for what moves: a sample at every frame, the same strands throughout, velocities that carry the points."""

from collections.abc import Iterator

import numpy as np
from pxr import Usd, UsdVol

from hairpipe.io.usd.check.finding import Fault, Rule
from hairpipe.io.usd.check.snapshot import Snapshot
from hairpipe.io.usd.check.stage import has_range

FOLLOWERS = ("velocities", "accelerations", "normals", "extent")
TOPOLOGY = ("curveVertexCounts", "faceVertexCounts", "faceVertexIndices", "primvars:hairId")
MISFIT = 0.75  # velocities may differ from the displacement by this part: they are those of the instants between
LISTED = 8  # gaps that a message names
ROUNDING = 64 * np.finfo(np.float32).eps  # of positions, in parts of the largest


def sample_gaps(prim: Usd.Prim) -> Iterator[Fault]:
    """Find frames without a sample: clients make one up from its neighbours and say nothing."""
    attribute, stage = _leader(prim), prim.GetStage()
    times = np.array(attribute.GetTimeSamples())
    times = times[times == np.round(times)]  # those between frames are for the shutter
    if len(times) < 2:
        return
    step = np.diff(times).min()
    start, end = (stage.GetStartTimeCode(), stage.GetEndTimeCode()) if has_range(stage) else times[[0, -1]]
    before, after = max(0, (times[0] - start) // step), max(0, (end - times[-1]) // step)
    gaps = np.concatenate([[before], np.round(np.diff(times) / step) - 1, [after]])
    firsts = np.concatenate([[times[0] - before * step], times + step])
    if gaps.any():
        listed = [
            f"{t:g} to {t + (n - 1) * step:g}" if n > 1 else f"{t:g}" for t, n in zip(firsts, gaps, strict=True) if n
        ]
        more = f" and {len(listed) - LISTED} more" if len(listed) > LISTED else ""
        message = f"has no sample at {', '.join(listed[:LISTED])}{more}; {gaps.sum():.0f} frames missing"
        yield Fault(str(attribute.GetPath()), message, float(firsts[np.argmax(gaps > 0)]))


def sample_range(prim: Usd.Prim) -> Iterator[Fault]:
    """Find samples that nobody plays since they lie outside of the stage's time codes."""
    attribute, stage = _leader(prim), prim.GetStage()
    times = attribute.GetTimeSamples() if has_range(stage) else []
    outside = [t for t in times if not stage.GetStartTimeCode() <= t <= stage.GetEndTimeCode()]
    if outside:
        span = f"{stage.GetStartTimeCode():g} to {stage.GetEndTimeCode():g}"
        yield Fault(str(attribute.GetPath()), f"{len(outside)} samples lie outside of {span}", outside[0])


def sample_times(prim: Usd.Prim) -> Iterator[Fault]:
    """Find velocities, normals and extents that are not sampled when the points are."""
    points = prim.GetAttribute("points")
    times = points.GetTimeSamples() if points else []
    for name in FOLLOWERS if len(times) > 1 else ():
        follower = prim.GetAttribute(name)
        lacking = sorted(set(times) - set(follower.GetTimeSamples())) if follower and follower.HasValue() else []
        if lacking:
            message = f"has no sample at {len(lacking)} of {len(times)} times at which points has one"
            yield Fault(str(follower.GetPath()), message, lacking[0])


def topology(prim: Usd.Prim) -> Iterator[Fault]:
    """Find strands, faces or ids that change in time: motion blur and value clips need them to stay."""
    for name in TOPOLOGY:
        attribute = prim.GetAttribute(name)
        times = attribute.GetTimeSamples() if attribute else []
        first = attribute.Get(times[0]) if len(times) > 1 else None
        changed = [time for time in times[1:] if attribute.Get(time) != first]
        if changed:
            yield Fault(str(attribute.GetPath()), f"changes in time, at {len(changed)} samples", changed[0])


def _leader(prim: Usd.Prim) -> Usd.Attribute:
    """Return the attribute that has a sample at every frame."""
    return prim.GetAttribute("filePath" if prim.IsA(UsdVol.OpenVDBAsset) else "points")


def velocity_match(before: Snapshot, after: Snapshot) -> Iterator[Fault]:
    """Find velocities that do not carry the points from one sample to the next, in units per second.

    (v0 + v1) / 2 = (x1 - x0) / (t1 - t0), up to the third derivative of x.
    """
    velocities = [array for array in (before.array("velocities", 3), after.array("velocities", 3)) if array is not None]
    arrays = [before.points, after.points, *velocities]
    if len(velocities) < 2 or len({len(array) for array in arrays}) > 1:
        return
    sound = np.logical_and.reduce([np.isfinite(array).all(axis=1) for array in arrays])
    start, end, v0, v1 = (array[sound].astype(np.float64) for array in arrays)
    frames = after.time.GetValue() - before.time.GetValue()
    told, seen = (v0 + v1) / 2 * frames / before.prim.GetStage().GetTimeCodesPerSecond(), end - start
    larger = max(np.linalg.norm(told), np.linalg.norm(seen))
    noise = ROUNDING * np.sqrt(start.size) * max(np.abs(start).max(initial=0), np.abs(end).max(initial=0))
    if np.linalg.norm(told - seen) > max(MISFIT * larger, noise):
        share = np.linalg.norm(told) / max(np.linalg.norm(seen), np.finfo(np.float64).tiny)
        message = f"carry the points {share:.2g} times as far as they go to {after.code:g}; units per second are right"
        yield Fault(before.path("velocities"), message, before.code)


RULES = (
    Rule("sample-gaps", "error", sample_gaps),
    Rule("sample-range", "warning", sample_range),
    Rule("sample-times", "error", sample_times),
    Rule("topology", "error", topology),
)
PAIR_RULES = (Rule("velocity-match", "warning", velocity_match),)
