"""Rules for moving shapes: a sample at every frame, the same strands at all times."""

import re
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from pxr import Usd, UsdVol

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.stage_metrics import has_range

FOLLOWERS = ("velocities", "accelerations", "normals", "extent")
TOPOLOGY = ("curveVertexCounts", "faceVertexCounts", "faceVertexIndices", "primvars:hairId")
LISTED = 8  # number of gaps in a message
NUMBER = re.compile(r"(\d+)\.\w+$")
NEAR = 2  # frames of a mistaken offset of files
CLOSE = 1e-2  # frames between samples of one rounded time


def sample_gaps(prim: Usd.Prim) -> Iterator[Fault]:
    """Find frames without a sample, which clients interpolate without a warning."""
    attribute = _leader(prim)
    stage = prim.GetStage()
    times = np.unique(attribute.GetTimeSamples())
    times = times[times == np.round(times)]  # others are for motion blur
    if len(times) < 2:
        return
    step = np.diff(times).min()
    start, end = (stage.GetStartTimeCode(), stage.GetEndTimeCode()) if has_range(stage) else times[[0, -1]]
    before = max(0, (times[0] - start) // step)
    after = max(0, (end - times[-1]) // step)
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
    """Find samples outside of the stage's time codes."""
    attribute = _leader(prim)
    stage = prim.GetStage()
    times = attribute.GetTimeSamples() if has_range(stage) else []
    outside = [t for t in times if not stage.GetStartTimeCode() <= t <= stage.GetEndTimeCode()]
    if outside:
        span = f"{stage.GetStartTimeCode():g} to {stage.GetEndTimeCode():g}"
        yield Fault(str(attribute.GetPath()), f"{len(outside)} samples lie outside of {span}", outside[0])


def sample_times(prim: Usd.Prim) -> Iterator[Fault]:
    """Find split samples, and velocities, normals and extents with other sample times than the points."""
    points = prim.GetAttribute("points")
    times = points.GetTimeSamples() if points else []
    twice = [late for early, late in pairwise(times) if late - early < CLOSE]
    if twice:
        yield Fault(str(points.GetPath()), f"has two samples within {CLOSE:g} of a frame; {len(twice)} such", twice[0])
    for name in FOLLOWERS if len(times) > 1 else ():
        follower = prim.GetAttribute(name)
        lacking = sorted(set(times) - set(follower.GetTimeSamples())) if follower and follower.HasValue() else []
        if lacking:
            message = f"has no sample at {len(lacking)} of {len(times)} times at which points has one"
            yield Fault(str(follower.GetPath()), message, lacking[0])


def topology(prim: Usd.Prim) -> Iterator[Fault]:
    """Find strands, faces or ids that change in time: motion blur and value clips require constant ones."""
    for name in TOPOLOGY:
        attribute = prim.GetAttribute(name)
        times = attribute.GetTimeSamples() if attribute else []
        first = attribute.Get(times[0]) if len(times) > 1 else None
        changed = [time for time in times[1:] if attribute.Get(time) != first]
        if changed:
            yield Fault(str(attribute.GetPath()), f"changes in time, at {len(changed)} samples", changed[0])


def frame_names(prim: Usd.Prim) -> Iterator[Fault]:
    """Find files of another frame than the one at which they are played, by the number in their name."""
    attribute = prim.GetAttribute("filePath")
    times = attribute.GetTimeSamples() if prim.IsA(UsdVol.OpenVDBAsset) else []
    names = {time: NUMBER.search(attribute.Get(time).path) for time in times if attribute.Get(time)}
    late = {time: int(found[1]) - time for time, found in names.items() if found}
    usual = np.median(list(late.values())) if late else 0.0
    wanted = 0.0 if abs(usual) <= NEAR else usual  # frames may be counted from 1
    wrong = [time for time, offset in late.items() if offset != wanted]
    if wrong:
        message = f"is frame {wrong[0] + late[wrong[0]]:g} by its name, not {wrong[0] + wanted:g}; {len(wrong)} such"
        yield Fault(str(attribute.GetPath()), message, wrong[0])


def _leader(prim: Usd.Prim) -> Usd.Attribute:
    """Return the attribute that has a sample at every frame."""
    return prim.GetAttribute("filePath" if prim.IsA(UsdVol.OpenVDBAsset) else "points")


RULES = (
    Rule("sample-gaps", "error", sample_gaps),
    Rule("sample-range", "warning", sample_range),
    Rule("sample-times", "error", sample_times),
    Rule("topology", "error", topology),
    Rule("frame-names", "warning", frame_names),
)
