"""Hair from a file of another program."""

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
    """Read strands from USD (BasisCurves) or TressFX (.tfx, version 3 or 4), and bind them to a body at rest.

    A root off the skin keeps its offset from the closest place of the body. A USD file gives ids (primvars hairId,
    groom_id or id), rest shape (pref or rest) and widths. If it has several shapes, the one with roots nearest to the
    skin is used; of curves without pins, the better of those with and without their end points.

    file            path of the hair file; curves of purpose guide are read only if a stage has no others
    unit            metres per unit of a .tfx file; a USD file states its unit
    up              vertical axis of a .tfx file
    time_code       time code of a USD file; by default that of the body, or the first with all samples
    segments        number of equal segments of every strand; by default that of the file
    segment_length  length of the longest segment, in place of their number; strands of different lengths then differ in
                    number
    shortest        minimum length of a segment: short strands have fewer segments, and strands below it are removed
    strands         number of strands to keep, at equal intervals in the order of the file; by default all
    reach           maximum distance of a root from the body
    tips            boundary condition of tips: bound to the closest place of the body like roots, free, or as in a .tfx
                    file
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
