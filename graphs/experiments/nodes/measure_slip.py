"""Slip of hair relative to its roots."""

from hairpipe.data import Ends, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_slip(hair: Frames[Strands], ends: Frames[Ends], time: Time) -> Table:
    """Measure the slip of every strand relative to the rigid motion of its root, and the tilt of the root."""
    from hairpipe.graphs.experiments.measure.slip import measure_slips

    return measure_slips(hair, ends, time.fps)
