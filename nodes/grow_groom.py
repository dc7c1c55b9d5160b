"""Hair grown on a body."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.groom.settings import SHORTEST, Comb, Curl, Style
from hairpipe.units import Ge, Gt, Interval, Metres
from hairpipe.values import Body, Groom
from hairpipe.values.painting import Paint, PaintedDegrees, PaintedMetres


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
    """Grow hair on the body's map "scalp", with uniform or painted density, and comb it from a parting.

    strands         number of roots on the scalp
    segments        number of equal segments of every strand. By default one per 5 mm and 16 per turn of a curl, from 25
                    to 200: errors of a network against rod theory of 0.7 % of the length for the tip of a straight
                    cantilever (1.8 % for 50 cm with 25), and of 3 % for the stiffness of a curl (12 to 21 % with 8 per
                    turn); of a rod less. Time and memory grow in proportion
    segment_length  length of the longest segment, in place of their number
    shortest        minimum length of a segment: short strands have fewer segments, and strands below it are removed
    density         painted density of roots; if absent, uniform
    length          length of a strand from root to tip
    lift            angle between the skin and a strand at its root
    bend            length over which a strand bends from the angle of lift to the combed direction
    volume          thickness of hair that lies on the body, each strand in its own layer
    comb            pull on hair that lies on the body
    curl            helix around the path of each strand; if absent, hair is straight
    seed            seed of all random numbers
    """
    from hairpipe.formats.pictures import read_image
    from hairpipe.groom.growing import grow
    from hairpipe.groom.resampling import Cut
    from hairpipe.values.painting import Canvas

    style = Style(length, lift, bend, volume, comb, curl)
    cut = Cut(segments, segment_length, shortest)
    return grow(Canvas(scalp, read_image, seed), style, density, strands, cut)
