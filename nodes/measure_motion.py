"""Speed of hair as a whole."""

from hairpipe.engine import Cuts, Frames, Time, node
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_motion(hair: Frames[Strands], time: Time, cuts: Cuts) -> Table:
    """Measure speed, maximum stretch, mean height and displacement of all strands at every frame."""
    from hairpipe.measure.motion import measure_speeds

    return measure_speeds(hair, time.fps, cuts)
