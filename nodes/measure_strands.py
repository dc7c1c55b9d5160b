"""What hair does over time, as numbers."""

from hairpipe.data import Ends, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_strands(hair: Frames[Strands], ends: Frames[Ends] | None, time: Time) -> Table:
    """Tip, span, stretch, speed, writhe and way gone since the first frame, of every strand at every frame.

    Where the ends are led, also how far the tip has been turned against the root.
    """
    from hairpipe.measure.strands import measure

    return measure(hair, time.fps, ends)
