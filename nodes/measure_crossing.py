"""How far locks have passed through each other, as numbers."""

from hairpipe.data import Groom, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_crossing(hair: Frames[Strands], lock: Groom, time: Time) -> Table:
    """Pairs of hairs of two locks, and hairs, that have changed sides: a row a frame. `lock` is the first of the two."""
    from hairpipe.measure.tuft import measure_crossing

    return measure_crossing(hair, len(lock.ids), time.fps)
