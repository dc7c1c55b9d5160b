"""Hair grown on a body."""

from typing import Annotated

from hairpipe.data import Body, Groom
from hairpipe.graph import node
from hairpipe.groom.cutting import SHORTEST
from hairpipe.groom.grow.style import Comb, Curl, Paint, PaintedDegrees, PaintedMetres, Style
from hairpipe.units import Ge, Gt, Interval, Metres


@node(frames="once")
def grow_groom(
    scalp: Body,
    *,
    strands: Annotated[int, Interval(ge=1, le=1_000_000)] = 2500,
    segments: Annotated[int, Interval(ge=1, le=10_000)] | None = None,
    segment_length: Annotated[Metres, Gt(0.0)] | None = None,
    shortest: Annotated[Metres, Gt(0.0)] = SHORTEST,
    density: Paint | None = None,
    length: PaintedMetres = Style.length,
    lift: PaintedDegrees = Style.lift,
    bend: Annotated[Metres, Gt(0.0)] = Style.bend,
    volume: Annotated[Metres, Ge(0.0)] = Style.volume,
    comb: Comb = Style.comb,
    curl: Curl | None = None,
    seed: Annotated[int, Ge(0)] = 0,
) -> Groom:
    """Hair grown where the body's map "scalp" says, evenly or as dense as painted, and combed from a parting.

    strands         number of roots
    segments        of equal length, of every strand; unless given, each has one for every 5 mm and 16 for every turn
                    of its curl, from 25 to 200: the tip of straight hair held out is then within 0.7 % of its length
                    of rod theory (50 cm of 25 segments: 1.8 %), the stiffness of a curl within 3 % (8 a turn: 12 to
                    21 % off). Time and memory of the simulation grow as their number
    segment_length  of the longest segment, in place of their number
    shortest        segment: strands have fewer where theirs are shorter, and shorter strands are left out
    density         paint that thins the hair out
    length          along the hair, from root to tip
    lift            between the skin and the hair that leaves it
    bend            length over which hair turns from there to where it is pulled
    volume          thickness of the hair lying on the body, each strand in a layer of its own
    comb            where hair lying on the body is pulled
    curl            curly hair; without it hair is straight
    seed            of all random numbers
    """
    from hairpipe.groom.cutting import Cut
    from hairpipe.groom.grow.growing import grow
    from hairpipe.groom.grow.paint import Canvas
    from hairpipe.io.image import read_image

    style = Style(length, lift, bend, volume, comb, curl)
    cut = Cut(segments, segment_length, shortest)
    return grow(Canvas(scalp, read_image, seed), style, density, strands, cut)
