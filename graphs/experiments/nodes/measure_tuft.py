"""Spread and clumping of hair over time."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_tuft(hair: Frames[Strands], time: Time) -> Table:
    """Measure the spread of tips and the distances between strands at every frame, compared with random placement."""
    from hairpipe.graphs.experiments.measure.spread import measure_spread

    return measure_spread(hair, time.fps)
