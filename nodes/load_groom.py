"""Hair made elsewhere."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.data import Body, Groom
from hairpipe.graph import node
from hairpipe.groom.cutting import SHORTEST
from hairpipe.units import Ge, Gt, Interval, Metres, Suffixes


@node(frames="once")
def load_groom(
    scalp: Body,
    *,
    file: Annotated[Path, Suffixes((".usd", ".usda", ".usdc", ".usdz", ".tfx"))],
    unit: Annotated[Metres, Gt(0.0)] = 1.0,
    up: Literal["y", "z"] = "y",
    time_code: float | None = None,
    segments: Annotated[int, Interval(ge=1, le=10_000)] | None = None,
    segment_length: Annotated[Metres, Gt(0.0)] | None = None,
    shortest: Annotated[Metres, Gt(0.0)] = SHORTEST,
    strands: Annotated[int, Ge(1)] | None = None,
    reach: Annotated[Metres, Gt(0.0)] = 0.02,
    tips: Literal["file", "free", "held"] = "file",
) -> Groom:
    """Strands of a USD file (BasisCurves) or a TressFX file (.tfx, version 3 or 4), bound to a body at rest.

    A root off the skin stays where it is and moves with the closest place of the body. Of a USD file, ids (primvars
    hairId, groom_id or id), rest shape (pref or rest) and widths are taken over; of its shapes that is taken whose
    roots lie nearest to the skin, of curves without pins among those with and without their ends.

    file            the hair; curves of purpose guide are read where a stage has no others
    unit            of a .tfx file, which does not state it; a USD file does
    up              axis of a .tfx file
    time_code       of a USD file; that of the body, or the first at which all of the file has samples, unless given
    segments        of equal length, of every strand; as many as it has unless given
    segment_length  of the longest segment, in place of their number: strands of unlike length have unlike numbers
    shortest        segment: strands have fewer where theirs are shorter, and shorter strands are left out
    strands         how many to keep, evenly spread over the order in the file; all unless given
    reach           farthest a root may lie from the body
    tips            held by the closest place of the body as roots are, free, or as a .tfx file states
    """
    from hairpipe.errors import BadInput
    from hairpipe.groom.cutting import Cut
    from hairpipe.groom.importing import adopt
    from hairpipe.io.body import USD_SUFFIXES
    from hairpipe.io.tfx import read_tfx
    from hairpipe.io.usd.read import read_curves

    suffix = file.suffix.lower()
    if suffix not in (".tfx", *USD_SUFFIXES):
        right = f"{', '.join(USD_SUFFIXES)} or .tfx"
        raise BadInput(f"hair is not read from {suffix or 'such'} files", where=file, right=right)
    cut = Cut(segments, segment_length, shortest)
    time = scalp.time if time_code is None else time_code
    curves = read_tfx(file, unit, up) if suffix == ".tfx" else read_curves(file, time=time)
    try:
        return adopt(scalp, curves, cut=cut, strands=strands, reach=reach, tips=tips)
    except BadInput as fault:
        raise BadInput(fault.what, where=fault.where or file, right=fault.right) from None
