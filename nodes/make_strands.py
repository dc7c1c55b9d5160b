"""Strands without a body, for tests and experiments."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.geometry.curl import Helix
from hairpipe.groom.settings import Tuft
from hairpipe.units import Gt, Interval, Metres
from hairpipe.values import Groom

Direction = tuple[float, float, float]
Shift = tuple[Metres, Metres, Metres]


@node(frames="once")
def make_strands(
    *,
    strands: Annotated[int, Interval(ge=1, le=1_000_000)] = 1,
    length: Annotated[Metres, Gt(0.0)] = 0.3,
    segments: Annotated[int, Interval(ge=1, le=10_000)] | None = None,
    segment_length: Annotated[Metres, Gt(0.0)] | None = None,
    direction: Direction = (1.0, 0.0, 0.0),
    spacing: Shift = (0.0, 0.0, 0.01),
    curl: Helix | None = None,
    arch: Annotated[float, Interval(ge=-2.0, le=2.0)] = 0.0,
    tuft: Tuft | None = None,
) -> Groom:
    """Build equal free strands in a row, with the first root at the origin.

    strands         number of strands in a row
    length          arc length of a strand from root to tip
    segments        number of equal segments of every strand; 50 by default
    segment_length  length of the longest segment, in place of their number
    direction       direction from root to tip
    spacing         distance from one root to the next
    curl            helix along the direction; if absent, strands are straight
    arch            ratio of rise to span of a parabola towards +Y, or towards +Z for strands along Y
    tuft            further rows of strands; if absent, one row
    """
    from hairpipe.groom.resampling import Cut
    from hairpipe.groom.strands import SEGMENTS, gather_tuft, lay_strands

    count = int(Cut(segments, segment_length).wanted(length, SEGMENTS))
    row = lay_strands(strands, length, count, direction, spacing, curl, arch)
    return gather_tuft(row, tuft) if tuft else row
