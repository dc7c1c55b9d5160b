"""Slip of hair relative to its roots."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Ends, Strands, Table


@node(frames="once")
def measure_slip(hair: Frames[Strands], ends: Frames[Ends], time: Time) -> Table:
    """Measure the slip of every strand relative to the rigid motion of its root, and the tilt of the root."""
    from hairpipe.graphs.experiments.measure.slip import measure_slips

    return measure_slips(hair, ends, time.fps)
