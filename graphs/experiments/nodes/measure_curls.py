"""Radius of curls over time."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_curls(hair: Frames[Strands], time: Time) -> Table:
    """Measure the radius of curls at every frame: the distance of points from the mean of the turn around them."""
    from hairpipe.graphs.experiments.measure.curls import measure_radii

    return measure_radii(hair, time.fps)
