"""Grooms for other programs: hair and guides with the names, types, units and axes that each of them reads.

Unreal reads primvars named groom_*, of the types int, float, float2, float3 and string alone, on curves with GroomAPI
(USDGroomConversion.cpp); it draws no guides, and takes points as they are. Houdini deforms hair by guides with the
primvar `rest`. Blender imports curves of purpose guide only on request.
"""

from dataclasses import replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from hairpipe import __version__
from hairpipe.formats.groom_shot import GroomShot
from hairpipe.formats.usd.curves import GUIDED, KNOWN
from hairpipe.formats.usd.shot import (
    author_body,
    author_curves,
    extent,
    floats,
    integers,
    pairs,
    primvar,
    set_body,
    vectors,
)
from hairpipe.formats.usd.stage import create_stage
from hairpipe.values import Strands
from hairpipe.values.groom import DIAMETERS, labels_of

TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens
Name = Literal["unreal", "houdini", "blender"]
Y_UP_TO_Z_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


class Target(NamedTuple):
    """What a program reads.

    metres   unit of its lengths [m], and up: its vertical axis
    schemas  API schemas of the curves
    ids, uv, colours  primvars of ids, texture coordinates of roots, and colours
    colour   type of colours
    rest     primvars of the rest shape
    apart    whether guides are curves of their own, of purpose guide
    """

    metres: float
    up: str
    schemas: tuple[str, ...]
    ids: str
    uv: str
    colours: str
    colour: Sdf.ValueTypeName
    rest: tuple[str, ...]
    apart: bool

    def placed(self, array: np.ndarray) -> np.ndarray:
        """Return points or velocities, (n, 3), in the unit and axes of the program."""
        return (array @ Y_UP_TO_Z_UP.T if self.up == TOKENS.z else array.astype(np.float64)) / self.metres


TARGETS: dict[str, Target] = {
    "unreal": Target(
        0.01, TOKENS.z, ("GroomAPI",), "groom_id", "groom_root_uv", "groom_color", TYPES.Float3Array, (), False
    ),
    "houdini": Target(1.0, TOKENS.y, (), "id", "st", "displayColor", TYPES.Color3fArray, ("rest", "pref"), True),
    "blender": Target(1.0, TOKENS.y, (), "id", "st", "displayColor", TYPES.Color3fArray, ("pref",), True),
}


def write_groom(path: Path, shot: GroomShot, name: Name) -> None:
    """Write hair and guides for a program; raises what `GroomShot.at` raises."""
    target = TARGETS[name]
    stage = create_stage(path, shot.fps)
    UsdGeom.SetStageUpAxis(stage, target.up)
    UsdGeom.SetStageMetersPerUnit(stage, target.metres)
    root = UsdGeom.Xform.Define(stage, "/groom").GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind("component")
    stage.GetRootLayer().customLayerData = {"hairpipe": {"version": __version__, "target": name}}
    maps = shot.maps({*KNOWN, *(GUIDED if shot.closest else ())})
    pieces = list[tuple[UsdGeom.BasisCurves, np.ndarray]]()
    for piece, strands in shot.pieces(target.apart).items():
        prim = UsdGeom.BasisCurves.Define(stage, f"/groom/{piece}")
        author(prim, shot, maps, strands, target)
        if piece == "guides":
            prim.CreatePurposeAttr(TOKENS.guide)
        pieces.append((prim, shot.rows(strands)))
    frames = [] if shot.hair is None else list(shot.hair)
    for start, end in [(frames[0], frames[-1])] if frames else []:
        stage.SetStartTimeCode(start)
        stage.SetEndTimeCode(end)
    for frame in frames:
        hair = shot.at(frame)
        widths = shot.widths(hair)
        for prim, rows in pieces:
            sample(prim, hair, rows, widths, frame, target)
    if shot.scalp is not None:
        mesh = replace(shot.scalp.mesh, points=target.placed(shot.scalp.mesh.points), velocities=None)
        prim = UsdGeom.Mesh.Define(stage, "/groom/scalp")
        author_body(prim, mesh)
        set_body(prim, mesh)
        for rest in target.rest:
            primvar(prim, rest, TYPES.Point3fArray, TOKENS.vertex, vectors(mesh.points))
    stage.Save()


def author(
    prim: UsdGeom.BasisCurves, shot: GroomShot, maps: dict[str, np.ndarray], strands: np.ndarray, target: Target
) -> None:
    """Author the constant values of some strands of the groom, (n,), and their points at rest; maps become primvars."""
    groom = shot.groom
    rows = shot.rows(strands)
    author_curves(prim, np.diff(groom.offsets)[strands], TOKENS.catmullRom)
    for schema in target.schemas:
        prim.GetPrim().AddAppliedSchema(schema)
    points = target.placed(groom.points[rows])
    widths = shot.widths(shot.first())[rows] / target.metres
    prim.CreatePointsAttr(vectors(points))
    prim.CreateExtentAttr(extent(points, widths.max(initial=0.0) / 2))
    prim.CreateWidthsAttr(floats(widths))
    prim.SetWidthsInterpolation(TOKENS.vertex)
    if shot.hairs is not None:
        diameters = floats(shot.diameters(shot.first())[rows] / target.metres)
        primvar(prim, DIAMETERS, TYPES.FloatArray, TOKENS.vertex, diameters)
    for name in target.rest:
        primvar(prim, name, TYPES.Point3fArray, TOKENS.vertex, vectors(points))
    uniform = {target.ids: groom.ids, "groom_guide": groom.guides, "groom_group_id": groom.groups}
    for name, values in uniform.items():
        if values is not None:
            primvar(prim, name, TYPES.IntArray, TOKENS.uniform, integers(values[strands]))
    if groom.groups is not None and groom.group_names:
        names = labels_of(groom.groups, groom.group_names)[strands].tolist()
        primvar(prim, "groom_group_name", TYPES.StringArray, TOKENS.uniform, Vt.StringArray(names))
    uv = pairs(groom.root_uv[strands])
    primvar(prim, target.uv, TYPES.Float2Array if target.uv != "st" else TYPES.TexCoord2fArray, TOKENS.uniform, uv)
    if groom.colours is not None:
        primvar(prim, target.colours, target.colour, TOKENS.vertex, vectors(groom.colours[rows]))
    if shot.closest is not None:
        for name, values in zip(GUIDED, shot.closest, strict=True):
            primvar(prim, name, TYPES.Float3Array, TOKENS.uniform, vectors(values[strands]))
    for name, values in maps.items():
        primvar(prim, name, TYPES.FloatArray, TOKENS.uniform, floats(values[strands]))


def sample(
    prim: UsdGeom.BasisCurves, hair: Strands, rows: np.ndarray, widths: np.ndarray, frame: int, target: Target
) -> None:
    """Author points, velocities, extent, and widths that are not those before, of some points (p,) at a frame.

    widths  of all points [m]
    """
    placed = target.placed(hair.points[rows])
    prim.GetPointsAttr().Set(vectors(placed), frame)
    prim.GetVelocitiesAttr().Set(vectors(target.placed(hair.velocities[rows])), frame)
    own = floats(widths[rows] / target.metres)
    attribute = prim.GetWidthsAttr()
    earlier = prim.GetPointsAttr().GetTimeSamples()[:-1]
    if attribute.GetNumTimeSamples() or attribute.Get() != own:
        for time in () if attribute.GetNumTimeSamples() else earlier[-1:]:
            attribute.Set(attribute.Get(), time)  # samples are interpolated: the change begins at the frame before
        attribute.Set(own, frame)
    prim.GetExtentAttr().Set(extent(placed, max(own, default=0.0) / 2), frame)
