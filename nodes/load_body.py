"""A body from a file."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.body.scalp import Scalp
from hairpipe.data import Body
from hairpipe.graph import node
from hairpipe.units import Interval, Metres, Suffixes


@node(frames="once")
def load_body(
    *,
    file: Annotated[Path, Suffixes((".obj", ".usd", ".usda", ".usdc", ".usdz"))],
    group: str | None = None,
    skeleton: Path | None = None,
    weights: Path | None = None,
    unit: Annotated[Metres, Interval(ge=1e-6, le=1e6)] = 1.0,
    up: Literal["y", "z"] = "y",
    time_code: float | None = None,
    joint: str = "head",
    scalp: Scalp | None = None,
) -> Body:
    """Mesh, skeleton, weights and painted maps from an OBJ or USD file; in metres, Y up, the face towards +Z.

    file       mesh of the body; a USD file has its skeleton, too
    group      to keep: a group or object of an OBJ file, the path of a prim of a USD file
    skeleton   MakeHuman rig (.mhskel) of an OBJ file
    weights    MakeHuman weights (.mhw) that go with it
    unit       metres in one unit of an OBJ file; a correction factor for a USD file, which states its own
    up         axis of an OBJ file that points up, or of a USD file that states a wrong one; Z-up bodies face -Y
    time_code  of a USD file; the first at which all of its meshes and curves have samples unless given
    joint      name of the one joint of a body without a skeleton: what it follows in a clip
    scalp      hairline to paint map "scalp" by; without, it is that of the file
    """
    from hairpipe.body.preparation import prepare
    from hairpipe.io.body import read_body

    body = read_body(file, group=group, skeleton=skeleton, weights=weights, time=time_code)
    return prepare(body, unit=unit, up=up, joint=joint, scalp=scalp)
