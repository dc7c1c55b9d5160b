"""How fast hair moves as a whole, as numbers."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Cuts, Frames, Time, node


@node(frames="once")
def measure_motion(hair: Frames[Strands], time: Time, cuts: Cuts) -> Table:
    """At every frame, one row for all strands: speed, the longest stretch, mean height, and the way gone."""
    from hairpipe.measure.motion import measure_speeds

    return measure_speeds(hair, time.fps, cuts)
