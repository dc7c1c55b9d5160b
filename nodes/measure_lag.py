"""Delay of hair after the head."""

from hairpipe.engine import Frames, node
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_lag(hair: Frames[Strands]) -> Table:
    """Measure the rotation of hair about the vertical, and its delay after the roots: one row."""
    from hairpipe.measure.motion import swing_table

    return swing_table(hair)
