"""Invariance of simulations: a mirrored or a scaled scene."""

from typing import Annotated, Literal

from hairpipe.engine import Frames, Time, node
from hairpipe.units import Gt, Interval
from hairpipe.values import Strands, Table


@node(frames="once")
def compare_hair(
    hair: Frames[Strands],
    truth: Frames[Strands],
    time: Time,
    *,
    mirror: Literal["x", "y", "z"] | None = None,
    scale: Annotated[float, Gt(0.0)] = 1.0,
    slower: Annotated[int, Interval(ge=1, le=100)] = 1,
) -> Table:
    """Measure the largest distance of hair from that of another scene, which is mirrored and scaled, at every frame.

    mirror  normal axis of the plane through the origin in which `truth` is mirrored; if absent, it is not
    scale   factor on the lengths of `truth`
    slower  factor on the times of `truth`
    """
    from hairpipe.graphs.experiments.measure.invariance import differences

    return differences(hair, truth, time.fps, mirror, scale, slower)
