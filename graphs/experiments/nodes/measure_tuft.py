"""How hair spreads and clumps over time, as numbers."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_tuft(hair: Frames[Strands], time: Time) -> Table:
    """At every frame, how far the tips are spread and how near strands are to each other, also against chance."""
    from hairpipe.measure.shape.tuft import measure_spread

    return measure_spread(hair, time.fps)
