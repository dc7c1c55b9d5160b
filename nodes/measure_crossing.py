"""How far locks have passed through each other, as numbers."""

from hairpipe.data import Groom, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_crossing(hair: Frames[Strands], lock: Groom, time: Time) -> Table:
    """How many pairs of hairs of two locks, and hairs, have changed sides: a row a frame. `lock` is the first."""
    from hairpipe.measure.shape.tuft import measure_crossing

    return measure_crossing(hair, len(lock.ids), time.fps)
