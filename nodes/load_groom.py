"""Hair made elsewhere."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.data import Body, Groom
from hairpipe.graph import node
from hairpipe.units import Ge, Gt, Interval, Metres, Suffixes


@node(frames="once")
def load_groom(
    scalp: Body,
    *,
    file: Annotated[Path, Suffixes((".usd", ".usda", ".usdc", ".usdz", ".tfx"))],
    unit: Annotated[Metres, Gt(0.0)] = 1.0,
    up: Literal["y", "z"] = "y",
    segments: Annotated[int, Interval(ge=1, le=10_000)] | None = None,
    strands: Annotated[int, Ge(1)] | None = None,
    reach: Annotated[Metres, Gt(0.0)] = 0.02,
) -> Groom:
    """Strands of a USD file (BasisCurves) or a TressFX file (.tfx), bound to a body at rest.

    A root off the skin stays where it is and moves with the closest place of the body.

    file      the hair; curves of purpose guide are read where a stage has no others
    unit      of a .tfx file, which does not say; a USD file does
    up        axis of a .tfx file
    segments  of equal length, of every strand; as many as it has unless given
    strands   how many to keep, evenly spread over the order in the file; all unless given
    reach     farthest a root may lie from the body
    """
    from hairpipe.errors import BadInput
    from hairpipe.groom.adopting import adopt
    from hairpipe.io.body import USD_SUFFIXES
    from hairpipe.io.tfx import read_tfx
    from hairpipe.io.usd.read import read_curves

    suffix = file.suffix.lower()
    if suffix not in (".tfx", *USD_SUFFIXES):
        right = f"{', '.join(USD_SUFFIXES)} or .tfx"
        raise BadInput(f"hair is not read from {suffix or 'such'} files", where=file, right=right)
    points, offsets = read_tfx(file, unit, up) if suffix == ".tfx" else read_curves(file)
    return adopt(scalp, points, offsets, segments=segments, strands=strands, reach=reach)
