"""Hair from a file of another program."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.engine import node
from hairpipe.formats.registry import list_parts, suffixes_of
from hairpipe.groom.settings import SHORTEST
from hairpipe.plain_file import Absent
from hairpipe.units import Ge, Gt, Interval, Metres, Reads, Suffixes
from hairpipe.values import Body, Groom


@node(frames="once")
def load_groom(
    scalp: Body,
    *,
    file: Annotated[Path, Suffixes(suffixes_of("strands")), Reads(list_parts)],
    unit: Annotated[Metres, Gt(0.0)] = 1.0,
    up: Literal["y", "z"] = "y",
    time_code: float | None = None,
    absent: Absent = "refuse",
    select: Literal["all", "guides", "hair"] = "all",
    points: Literal["equal", "file"] = "equal",
    segments: Annotated[int, Interval(ge=1, le=10_000)] | None = None,
    segment_length: Annotated[Metres, Gt(0.0)] | None = None,
    shortest: Annotated[Metres, Gt(0.0)] = SHORTEST,
    strands: Annotated[int, Ge(1)] | None = None,
    reach: Annotated[Metres, Gt(0.0)] = 0.02,
    roots: Literal["first", "nearest"] = "first",
    inside: Literal["keep", "push", "cut"] = "keep",
    tips: Literal["file", "free", "held"] = "file",
) -> Groom:
    """Read strands from a file and bind them to a body at rest.

    A root off the skin keeps its offset from the closest place of the body. If a USD file has several shapes, the one
    with roots nearest to the skin is used; of curves without pins, the better of those with and without their end
    points.

    file            path of the hair file; curves of purpose guide are read only if a stage has no others
    unit            metres per unit of a file that states none (all but USD)
    up              vertical axis of such a file
    time_code       time code of a USD file; by default that of the body, or the first with all samples
    absent          treatment of absent files that a USD stage names: refuse, or warn and read the rest
    select          strands of the file: all, only those marked as guides, or only the others
    points          segments of strands: equal (of one length, as simulations need; strands that have them are
                    unchanged) or file (between the points of the file, for export)
    segments        number of equal segments of every strand; by default that of the file
    segment_length  length of the longest segment, in place of their number; strands of different lengths then differ in
                    number
    shortest        minimum length of a segment: short strands have fewer segments, and strands below it are removed
    strands         number of strands to keep, at equal intervals in the order of the file; by default all
    reach           maximum distance of a root from the body
    roots           root of a curve: its first point, or the end nearer to the body, as reconstructions need; curves
                    without an end within reach are then removed
    inside          points inside the body: kept, or pushed out to the skin, or cut off with what follows. In the last
                    two cases a strand begins where it leaves the body
    tips            boundary condition of tips: bound to the closest place of the body like roots, free, or as in a .tfx
                    file
    """
    from hairpipe.errors import BadInput
    from hairpipe.formats.registry import read_strands
    from hairpipe.groom.importing import adopt, selected
    from hairpipe.groom.resampling import Cut

    if points == "file" and (segments or segment_length):
        raise BadInput('segments with points = "file"', right='one of them, or points = "equal"')
    cut = None if points == "file" else Cut(segments, segment_length, shortest)
    time = scalp.time if time_code is None else time_code
    try:
        curves = selected(read_strands(file, unit, up, time, guides=select != "all", absent=absent), select)
        return adopt(
            scalp,
            curves,
            cut=cut,
            strands=strands,
            reach=reach,
            tips=tips,
            nearer_end=roots == "nearest",
            inside=inside,
        )
    except BadInput as fault:
        raise BadInput(fault.what, where=fault.where or file, right=fault.right) from None
