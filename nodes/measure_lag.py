"""Delay of hair after the head."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, node


@node(frames="once")
def measure_lag(hair: Frames[Strands]) -> Table:
    """Measure the rotation of hair about the vertical, and its delay after the roots: one row."""
    from hairpipe.measure.swing import swing_table

    return swing_table(hair)
