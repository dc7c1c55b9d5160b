"""Rules for the unit, rate and time range of a stage; OpenUSD has no validators for these values."""

import math
from collections.abc import Iterator

from pxr import Usd, UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule


def metres_per_unit(stage: Usd.Stage) -> Iterator[Fault]:
    """Find a unit that is not a positive length; the validator of OpenUSD finds only a missing one."""
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    if not (math.isfinite(scale) and scale > 0):
        yield Fault("/", f"metersPerUnit is {scale:g}; it has to be positive")


def frame_rate(stage: Usd.Stage) -> Iterator[Fault]:
    """Find a stage with undefined velocities, or with another playback rate than its frames."""
    codes = stage.GetTimeCodesPerSecond()
    frames = stage.GetFramesPerSecond()
    if not (math.isfinite(codes) and codes > 0):
        yield Fault("/", f"timeCodesPerSecond is {codes:g}; it has to be positive")
    elif not stage.HasAuthoredMetadata("timeCodesPerSecond"):
        if is_animated(stage):
            yield Fault("/", "no timeCodesPerSecond")
    elif not math.isclose(codes, frames, rel_tol=1e-6):
        yield Fault("/", f"timeCodesPerSecond is {codes:g} and framesPerSecond {frames:g}; they have to be equal")


def time_codes(stage: Usd.Stage) -> Iterator[Fault]:
    """Find a stage without a time range."""
    if not stage.HasAuthoredTimeCodeRange():
        if is_animated(stage):
            yield Fault("/", "no startTimeCode and endTimeCode")
    elif not has_range(stage):
        yield Fault("/", f"startTimeCode {stage.GetStartTimeCode():g} is after endTimeCode {stage.GetEndTimeCode():g}")


def has_range(stage: Usd.Stage) -> bool:
    """Return whether the stage has a valid time range."""
    start = stage.GetStartTimeCode()
    end = stage.GetEndTimeCode()
    return stage.HasAuthoredTimeCodeRange() and math.isfinite(end - start) and start <= end


def is_animated(stage: Usd.Stage) -> bool:
    """Return whether any attribute has values at more than one time."""
    prims = stage.Traverse(Usd.TraverseInstanceProxies())
    return any(a.ValueMightBeTimeVarying() for prim in prims for a in prim.GetAttributes())


RULES = (
    Rule("metres-per-unit", "error", metres_per_unit),
    Rule("frame-rate", "error", frame_rate),
    Rule("time-codes", "error", time_codes),
)
