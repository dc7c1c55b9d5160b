"""How alike strands of a fan are."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_fan(hair: Frames[Strands], time: Time) -> Table:
    """Largest distance of a point of strands of `fan_strands` from that of the first, turned to it, at every frame."""
    from hairpipe.graphs.experiments.studies.accuracy.fan import fan_table

    return fan_table(hair, time.fps)
