"""Rotation invariance of strands in a fan."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_fan(hair: Frames[Strands], time: Time) -> Table:
    """Measure the largest distance between strands of `fan_strands` and the rotated first strand, at every frame."""
    from hairpipe.graphs.experiments.studies.accuracy.fan import fan_table

    return fan_table(hair, time.fps)
