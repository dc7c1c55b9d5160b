"""How far hair has slipped, as numbers."""

from hairpipe.data import Ends, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_slip(hair: Frames[Strands], ends: Frames[Ends], time: Time) -> Table:
    """How far every strand has moved on what its root moves with, and how steep that has become."""
    from hairpipe.measure.slip import measure_slips

    return measure_slips(hair, ends, time.fps)
