"""What hair does over time, as numbers."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_strands(hair: Frames[Strands], time: Time) -> Table:
    """Tip, span, stretch, speed, writhe and way gone since the first frame, of every strand at every frame."""
    from hairpipe.measure.strands import measure

    return measure(hair, time.fps)
