"""Tension along strands."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_tension(groom: Groom, states: Frames[HairState], time: Time, *, moments: tuple[int, ...] = ()) -> Table:
    """Measure the tension of every segment of every strand, and the angle that the strand has turned up to it.

    moments  frames to examine; by default all frames of the run
    """
    from hairpipe.graphs.experiments.measure.tensions import measure_tensions

    return measure_tensions(groom, states, time.fps, moments)
