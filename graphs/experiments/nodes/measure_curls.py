"""How wide curls are over time, as numbers."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_curls(hair: Frames[Strands], time: Time) -> Table:
    """The radius of the curls at every frame: how far points are from the mean of one turn about them."""
    from hairpipe.measure.shape.curls import measure_radii

    return measure_radii(hair, time.fps)
