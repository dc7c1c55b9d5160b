"""Grooms for other programs: hair and guides with the names, types, units and axes that each of them reads.

Unreal reads primvars named groom_*, of the types int, float, float2, float3 and string alone, on curves with GroomAPI
(USDGroomConversion.cpp); it draws no guides, and takes points as they are. Houdini deforms hair by guides with the
primvar `rest`. Blender imports curves of purpose guide only on request.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, Vt

from hairpipe import __version__
from hairpipe.data.curves import labels_of
from hairpipe.errors import BadInput
from hairpipe.io.groom_shot import GroomShot
from hairpipe.io.usd.samples import extent, hold_body, integers, vectors
from hairpipe.io.usd.stage import create_stage
from hairpipe.io.usd.statics import author_body, author_curves

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
    pieces = list(pieces_of(stage, shot, target))
    frames = [] if shot.hair is None else list(shot.hair)
    for start, end in [(frames[0], frames[-1])] if frames else []:
        stage.SetStartTimeCode(start)
        stage.SetEndTimeCode(end)
    for frame in frames:
        hair = shot.at(frame)
        for prim, rows in pieces:
            sample(prim, hair.points[rows], hair.velocities[rows], frame, target)
    if shot.scalp is not None:
        mesh = replace(shot.scalp.mesh, points=turned(shot.scalp.mesh.points, target) / target.metres, velocities=None)
        prim = UsdGeom.Mesh.Define(stage, "/groom/scalp")
        author_body(prim, mesh)
        hold_body(prim, mesh)
        for rest in target.rest:
            primvar(prim, rest, TYPES.Point3fArray, TOKENS.vertex, vectors(mesh.points))
    stage.Save()


def pieces_of(stage: Usd.Stage, shot: GroomShot, target: Target) -> Iterator[tuple[UsdGeom.BasisCurves, np.ndarray]]:
    """Author the constant values of all curves; yield each prim and its points, (p,)."""
    for name, strands in shot.pieces(target.apart).items():
        prim = UsdGeom.BasisCurves.Define(stage, f"/groom/{name}")
        author(prim, shot, strands, target)
        if name == "guides":
            prim.CreatePurposeAttr(TOKENS.guide)
        yield prim, shot.rows(strands)


def author(prim: UsdGeom.BasisCurves, shot: GroomShot, strands: np.ndarray, target: Target) -> None:
    """Author the constant values of some strands of the groom, (n,), and their points at rest.

    Maps of the groom become primvars; BadInput where one has the name of another primvar.
    """
    groom = shot.groom
    rows = shot.rows(strands)
    author_curves(prim, np.diff(groom.offsets)[strands], TOKENS.catmullRom)
    for schema in target.schemas:
        prim.GetPrim().AddAppliedSchema(schema)
    points = turned(groom.points[rows], target) / target.metres
    widths = shot.widths(rows) / target.metres
    prim.CreatePointsAttr(vectors(points))
    prim.CreateExtentAttr(extent(points, widths.max(initial=0.0) / 2))
    prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy(widths.astype(np.float32)))
    prim.SetWidthsInterpolation(TOKENS.vertex)
    for name in target.rest:
        primvar(prim, name, TYPES.Point3fArray, TOKENS.vertex, vectors(points))
    uniform = {target.ids: groom.ids, "groom_guide": groom.guides, "groom_group_id": groom.groups}
    for name, values in uniform.items():
        if values is not None:
            primvar(prim, name, TYPES.IntArray, TOKENS.uniform, integers(values[strands]))
    if groom.groups is not None and groom.group_names:
        names = labels_of(groom.groups, groom.group_names)[strands].tolist()
        primvar(prim, "groom_group_name", TYPES.StringArray, TOKENS.uniform, Vt.StringArray(names))
    uv = Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(groom.root_uv[strands], np.float32))
    primvar(prim, target.uv, TYPES.Float2Array if target.uv != "st" else TYPES.TexCoord2fArray, TOKENS.uniform, uv)
    if groom.colours is not None:
        primvar(prim, target.colours, target.colour, TOKENS.vertex, vectors(groom.colours[rows]))
    if shot.closest is not None:
        closest = zip(("groom_closest_guides", "groom_guide_weights"), shot.closest, strict=True)
        for name, values in closest:
            primvar(prim, name, TYPES.Float3Array, TOKENS.uniform, vectors(values[strands]))
    for name, values in groom.maps.items():
        name = name if Sdf.Path.IsValidNamespacedIdentifier(name) else Tf.MakeValidIdentifier(name)
        if UsdGeom.PrimvarsAPI(prim).HasPrimvar(name):
            what = f"the map '{name}' of the groom has the name of another primvar"
            raise BadInput(what, where="groom", right="another name")
        own = Vt.FloatArray.FromNumpy(np.ascontiguousarray(values[strands], np.float32))
        primvar(prim, name, TYPES.FloatArray, TOKENS.uniform, own)


def sample(prim: UsdGeom.BasisCurves, points: np.ndarray, velocities: np.ndarray, frame: int, target: Target) -> None:
    """Author points [m], velocities [m/s], (p, 3) each, and extent of curves at a frame."""
    placed = turned(points, target) / target.metres
    prim.GetPointsAttr().Set(vectors(placed), frame)
    prim.GetVelocitiesAttr().Set(vectors(turned(velocities, target) / target.metres), frame)
    widest = float(np.max(prim.GetWidthsAttr().Get()))
    prim.GetExtentAttr().Set(extent(placed, widest / 2), frame)


def turned(vectors_: np.ndarray, target: Target) -> np.ndarray:
    """Return vectors (n, 3) with the vertical axis of a program; pure."""
    return vectors_ @ Y_UP_TO_Z_UP.T if target.up == TOKENS.z else vectors_.astype(np.float64)


def primvar(prim: UsdGeom.Gprim, name: str, kind: Sdf.ValueTypeName, interpolation: str, value: object) -> None:
    """Author a primvar."""
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, interpolation).Set(value)
