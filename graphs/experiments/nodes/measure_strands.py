"""Motion of individual strands, in numbers."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Ends, Strands, Table


@node(frames="once")
def measure_strands(hair: Frames[Strands], ends: Frames[Ends] | None, time: Time) -> Table:
    """Measure tip, span, stretch, speed, writhe and path length of every strand at every frame.

    With `ends`, the table has the rotation of the tip relative to the root.
    """
    from hairpipe.graphs.experiments.measure.strands import measure

    return measure(hair, time.fps, ends)
