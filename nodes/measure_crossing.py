"""Penetration of locks, in numbers."""

from hairpipe.data import Groom, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_crossing(hair: Frames[Strands], lock: Groom, time: Time) -> Table:
    """Count strands that passed through strands of another lock, and their pairs; `lock` is the first lock."""
    from hairpipe.measure.tuft import measure_crossing

    return measure_crossing(hair, len(lock.ids), time.fps)
