"""Speed and stretch of hair at each frame of a simulation."""

from hairpipe.engine import node
from hairpipe.values import Groom, Strands, Table


@node(frames="each")
def watch_hair(hair: Strands, groom: Groom) -> Table:
    """Measure speeds, maximum stretch relative to the groom, and mean height of all strands: one row.

    A wedge stops a variant at the first frame that fails one of its criteria.
    """
    from hairpipe.measure.motion import watch

    return watch(hair, groom)
