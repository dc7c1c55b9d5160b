"""Strands for tests and experiments, without a body."""

from typing import Annotated

from hairpipe.data import Groom
from hairpipe.graph import node
from hairpipe.groom.helix import Helix
from hairpipe.groom.tuft import Tuft
from hairpipe.units import Gt, Interval, Metres

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
    """Strands in a row, all alike, the root of the first at the origin; no body holds them.

    strands         number of roots
    length          along the segments, from root to tip
    segments        of equal length, of every strand; 50 unless given
    segment_length  of the longest segment, in place of their number
    direction       from root to tip
    spacing         from one root to the next
    curl            helix along the direction; straight without it
    arch            rise over span of a parabola towards +Y, or +Z where the strand lies along Y
    tuft            more such rows; one row without it
    """
    from hairpipe.groom.cutting import Cut
    from hairpipe.groom.strands import SEGMENTS, lay_strands
    from hairpipe.groom.tuft import gather_tuft

    count = int(Cut(segments, segment_length).wanted(length, SEGMENTS))
    row = lay_strands(strands, length, count, direction, spacing, curl, arch)
    return gather_tuft(row, tuft) if tuft else row
