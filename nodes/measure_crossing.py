"""Penetration of locks, in numbers."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Groom, Strands, Table


@node(frames="once")
def measure_crossing(hair: Frames[Strands], lock: Groom, time: Time) -> Table:
    """Count strands that passed through strands of another lock, and their pairs; `lock` is the first lock."""
    from hairpipe.measure.contact import measure_crossing

    return measure_crossing(hair, len(lock.ids), time.fps)
