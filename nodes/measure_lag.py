"""How hair lags behind the head, as numbers."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, node


@node(frames="once")
def measure_lag(hair: Frames[Strands]) -> Table:
    """How far hair turns about the vertical, and how long after its roots: one row."""
    from hairpipe.measure.swing import swing_table

    return swing_table(hair)
