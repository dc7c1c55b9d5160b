"""Each planted defect is named, at its place, and nothing else is."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, UsdVol, Vt

TYPES, TOKENS, NAN = Sdf.ValueTypeNames, UsdGeom.Tokens, float("nan")
HAIR, BODY, SKIN, FIELD = "/shot/hair", "/shot/body", "/shot/char/skin", "/shot/volume/surface"


def change(path: str, name: str, edit: Callable[[np.ndarray], np.ndarray], time: float = 1003) -> Callable:
    """Plant another value of an attribute, at one time if it has samples."""

    def plant(stage: Usd.Stage) -> None:
        attribute = stage.GetAttributeAtPath(f"{path}.{name}")
        at = Usd.TimeCode(time) if attribute.GetNumTimeSamples() else Usd.TimeCode.Default()
        old = attribute.Get(at)
        attribute.Set(type(old).FromNumpy(np.ascontiguousarray(edit(np.array(old)))), at)

    return plant


def put(path: str, name: str, value: object) -> Callable:
    """Plant a value that does not change."""
    return lambda stage: stage.GetAttributeAtPath(f"{path}.{name}").Set(value)


def remove(path: str, name: str) -> Callable:
    return lambda stage: stage.GetPrimAtPath(path).RemoveProperty(name)


def forget(path: str, name: str, *times: float) -> Callable:
    """Plant a gap in the samples."""
    return lambda stage: [stage.GetAttributeAtPath(f"{path}.{name}").ClearAtTime(time) for time in times]


def layer(edit: Callable[[Sdf.Layer], object]) -> Callable:
    return lambda stage: edit(stage.GetRootLayer())


def scaled(factor: float) -> Callable[[Usd.Stage], None]:
    """Plant velocities in another unit, at every frame."""

    def plant(stage: Usd.Stage) -> None:
        for time in range(1001, 1006):
            change(HAIR, "velocities", lambda v: v * np.float32(factor), time)(stage)

    return plant


def retype(path: str, name: str, kind: Sdf.ValueTypeName, value: object) -> Callable:
    """Plant an attribute of another type than the schema's."""

    def plant(stage: Usd.Stage) -> None:
        prim = stage.GetRootLayer().GetPrimAtPath(path)
        if name in prim.properties:
            prim.RemoveProperty(prim.properties[name])
        Sdf.AttributeSpec(prim, name, kind).default = value

    return plant


def primvar(name: str, interpolation: str) -> Callable:
    return lambda s: UsdGeom.PrimvarsAPI(s.GetPrimAtPath(HAIR)).GetPrimvar(name).SetInterpolation(interpolation)


def curve(counts: list[int], **tokens: str) -> Callable[[Usd.Stage], None]:
    """Plant a second, still groom of this shape."""

    def plant(stage: Usd.Stage) -> None:
        prim = UsdGeom.BasisCurves.Define(stage, "/shot/more")
        total = sum(counts)
        prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.linspace(0, 1, 3 * total, dtype=np.float32).reshape(-1, 3)))
        prim.CreateCurveVertexCountsAttr(counts)
        prim.CreateWidthsAttr([0.001])
        prim.SetWidthsInterpolation(TOKENS.constant)
        prim.CreateExtentAttr(UsdGeom.Curves.ComputeExtent(prim.GetPointsAttr().Get(), prim.GetWidthsAttr().Get()))
        for name, token in {"type": "cubic", "basis": "catmullRom", "wrap": "pinned", **tokens}.items():
            prim.GetPrim().GetAttribute(name).Set(token)

    return plant


def unbind(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath(HAIR).RemoveAPI(UsdShade.MaterialBindingAPI)


def misbind(target: str) -> Callable:
    return lambda s: UsdShade.MaterialBindingAPI(s.GetPrimAtPath(HAIR)).GetDirectBindingRel().SetTargets([target])


def vdb(frame: int, text: str) -> Callable:
    return lambda s: Path(s.GetRootLayer().realPath).with_name(f"body.{frame}.vdb").write_text(text)


def absolute(stage: Usd.Stage) -> None:
    path = Path(stage.GetRootLayer().realPath).with_name("body.1002.vdb")
    stage.GetAttributeAtPath(f"{FIELD}.filePath").Set(Sdf.AssetPath(str(path)), 1002)


def drop(stage: Usd.Stage, name: str) -> None:
    Path(stage.GetRootLayer().realPath).with_name(name).unlink()


DEFECTS: dict[str, tuple[Callable[[Usd.Stage], object], str, str]] = {
    # the stage
    "no default prim": (lambda s: s.ClearDefaultPrim(), "default-prim", "/"),
    "wrong default prim": (layer(lambda x: setattr(x, "defaultPrim", "none")), "default-prim", "/"),
    "no up axis": (lambda s: s.ClearMetadata("upAxis"), "up-axis", "/"),
    "no units": (lambda s: s.ClearMetadata("metersPerUnit"), "metres-per-unit", "/"),
    "negative units": (lambda s: s.SetMetadata("metersPerUnit", -1.0), "metres-per-unit", "/"),
    "two frame rates": (lambda s: s.SetFramesPerSecond(25), "frame-rate", "/"),
    "no frame rate": (layer(lambda x: x.ClearTimeCodesPerSecond()), "frame-rate", "/"),
    "no frame rates at all": (
        layer(lambda x: (x.ClearTimeCodesPerSecond(), x.ClearFramesPerSecond())),
        "frame-rate",
        "/",
    ),
    "no range": (layer(lambda x: (x.ClearStartTimeCode(), x.ClearEndTimeCode())), "time-codes", "/"),
    "range backwards": (lambda s: s.SetEndTimeCode(1000), "time-codes", "/"),
    "endless range": (lambda s: s.SetEndTimeCode(float("inf")), "time-codes", "/"),
    # curves
    "points too few": (change(HAIR, "points", lambda p: p[:-1]), "curve-counts", f"{HAIR}.curveVertexCounts"),
    "counts too few": (
        change(HAIR, "curveVertexCounts", lambda n: n[:-1]),
        "curve-counts",
        f"{HAIR}.curveVertexCounts",
    ),
    "counts negative": (
        change(HAIR, "curveVertexCounts", lambda n: np.array([-5, 15, 5, 5, 5, 5], np.int32)),
        "curve-counts",
        f"{HAIR}.curveVertexCounts",
    ),
    "no counts": (remove(HAIR, "curveVertexCounts"), "curve-counts", f"{HAIR}.curveVertexCounts"),
    "one point": (curve([4, 1]), "curve-length", "/shot/more.curveVertexCounts"),
    "no point": (curve([4, 0]), "curve-length", "/shot/more.curveVertexCounts"),
    "line of one": (curve([4, 1], type="linear", wrap="nonperiodic"), "curve-length", "/shot/more.curveVertexCounts"),
    "bspline": (curve([4], basis="bspline"), "hair-basis", "/shot/more.basis"),
    "unpinned": (curve([4], wrap="nonperiodic"), "hair-basis", "/shot/more.wrap"),
    "unknown wrap": (lambda s: s.GetAttributeAtPath(f"{HAIR}.wrap").Set("nailed"), "token hair-basis", f"{HAIR}.wrap"),
    "no basis": (remove(HAIR, "basis"), "hair-basis curve-length", f"{HAIR}.basis {HAIR}.curveVertexCounts"),
    "no widths": (remove(HAIR, "widths"), "widths", f"{HAIR}.widths"),
    "widths too few": (change(HAIR, "widths", lambda w: w[:-1]), "widths", f"{HAIR}.widths"),
    "width negative": (
        change(HAIR, "widths", lambda w: np.where(np.arange(30) == 4, -w, w)),
        "widths",
        f"{HAIR}.widths",
    ),
    "widths varying": (
        lambda s: UsdGeom.Curves(s.GetPrimAtPath(HAIR)).SetWidthsInterpolation("varying"),
        "widths",
        f"{HAIR}.widths",
    ),
    "ids twice": (change(HAIR, "primvars:hairId", lambda i: i // 2), "hair-ids", f"{HAIR}.primvars:hairId"),
    # counts and numbers
    "NaN": (
        change(HAIR, "points", lambda p: np.where(np.arange(30)[:, None] == 7, np.float32(NAN), p)),
        "finite",
        f"{HAIR}.points",
    ),
    "infinite width": (
        change(HAIR, "widths", lambda w: np.where(np.arange(30) == 3, np.float32(np.inf), w)),
        "finite",
        f"{HAIR}.widths",
    ),
    "NaN rest": (change(HAIR, "primvars:pref", lambda p: p * np.float32(NAN)), "finite", f"{HAIR}.primvars:pref"),
    "NaN velocity": (change(BODY, "velocities", lambda v: v * np.float32(NAN)), "finite", f"{BODY}.velocities"),
    "velocities too few": (change(HAIR, "velocities", lambda v: v[:-1]), "element-count", f"{HAIR}.velocities"),
    "pref too few": (change(HAIR, "primvars:pref", lambda p: p[:-1]), "element-count", f"{HAIR}.primvars:pref"),
    "st too many": (change(HAIR, "primvars:st", lambda p: np.tile(p, (2, 1))), "element-count", f"{HAIR}.primvars:st"),
    "ids too few": (change(HAIR, "primvars:hairId", lambda i: i[1:]), "element-count", f"{HAIR}.primvars:hairId"),
    "normals too few": (change(BODY, "normals", lambda n: n[:-1]), "element-count", f"{BODY}.normals"),
    "uv too few": (change(BODY, "primvars:st", lambda p: p[:-1]), "element-count", f"{BODY}.primvars:st"),
    "pref varying": (primvar("pref", "varying"), "hair-interpolation element-count", f"{HAIR}.primvars:pref"),
    "st on vertices": (
        lambda s: (primvar("st", "vertex")(s), change(HAIR, "primvars:st", lambda p: np.tile(p, (5, 1)))(s)),
        "hair-interpolation",
        f"{HAIR}.primvars:st",
    ),
    "face counts": (change(BODY, "faceVertexCounts", lambda n: n[:-1]), "mesh-faces", f"{BODY}.faceVertexCounts"),
    "face index": (change(BODY, "faceVertexIndices", lambda i: i + 1), "mesh-faces", f"{BODY}.faceVertexIndices"),
    "two corners": (
        change(BODY, "faceVertexCounts", lambda n: np.array([2, 4, 3, 3], np.int32)),
        "mesh-faces",
        f"{BODY}.faceVertexCounts",
    ),
    "no extent": (remove(HAIR, "extent"), "extent", f"{HAIR}.extent"),
    "extent too small": (change(HAIR, "extent", lambda e: e * np.float32(0.9)), "extent", f"{HAIR}.extent"),
    "extent without width": (
        change(HAIR, "extent", lambda e: e + np.float32([[4e-5], [-4e-5]])),
        "extent",
        f"{HAIR}.extent",
    ),
    "extent too large": (change(BODY, "extent", lambda e: e * np.float32(3)), "extent", f"{BODY}.extent"),
    # motion
    "frame missing": (
        lambda s: [forget(HAIR, name, 1003)(s) for name in ("points", "velocities", "extent")],
        "sample-gaps",
        f"{HAIR}.points",
    ),
    "last frames missing": (
        lambda s: [forget(HAIR, name, 1004, 1005)(s) for name in ("points", "velocities", "extent")],
        "sample-gaps",
        f"{HAIR}.points",
    ),
    "level set missing": (forget(FIELD, "filePath", 1004), "sample-gaps", f"{FIELD}.filePath"),
    "frames outside": (
        lambda s: s.SetEndTimeCode(1004),
        "sample-range",
        f"{BODY}.points {HAIR}.points {FIELD}.filePath",
    ),
    "velocity sample missing": (forget(HAIR, "velocities", 1005), "sample-times", f"{HAIR}.velocities"),
    "extent sample missing": (forget(BODY, "extent", 1003), "sample-times extent", f"{BODY}.extent"),
    "velocities per frame": (scaled(1 / 24), "velocity-match", f"{HAIR}.velocities"),
    "velocities backwards": (scaled(-1), "velocity-match", f"{HAIR}.velocities"),
    "velocities lost": (scaled(0), "velocity-match", f"{HAIR}.velocities"),
    "ids change": (
        lambda s: [
            s.GetAttributeAtPath(f"{HAIR}.primvars:hairId").Set([n + t for n in range(6)], 1001 + t) for t in range(5)
        ],
        "topology",
        f"{HAIR}.primvars:hairId",
    ),
    "strands change": (
        lambda s: [
            s.GetAttributeAtPath(f"{HAIR}.curveVertexCounts").Set([5 + t, 5 - t, 5, 5, 5, 5], 1001 + t)
            for t in range(2)
        ],
        "topology",
        f"{HAIR}.curveVertexCounts",
    ),
    # prims
    "shape under shape": (
        lambda s: UsdGeom.Mesh.Define(s, f"{HAIR}/child").GetPrim().SetTypeName("Cube"),
        "nested-gprim",
        f"{HAIR}/child",
    ),
    "component in a component": (
        lambda s: [Usd.ModelAPI(s.GetPrimAtPath(path)).SetKind("component") for path in ("/shot", "/shot/prop")],
        "kind",
        "/shot/prop",
    ),
    "double widths": (
        retype(HAIR, "widths", TYPES.DoubleArray, Vt.DoubleArray(30, 8e-5)),
        "attribute-type",
        f"{HAIR}.widths",
    ),
    "binding without API": (unbind, "material-binding", HAIR),
    "binding to nothing": (misbind("/shot/Looks/gone"), "dangling-target", f"{HAIR}.material:binding"),
    "binding to a mesh": (misbind(BODY), "material-binding", f"{HAIR}.material:binding"),
    "shader without id": (remove("/shot/Looks/hair/surface", "info:id"), "shader-id", "/shot/Looks/hair/surface"),
    "surface to nothing": (
        lambda s: s.RemovePrim("/shot/Looks/hair/surface"),
        "dangling-target",
        "/shot/Looks/hair.outputs:surface",
    ),
    "field to nothing": (lambda s: s.RemovePrim(FIELD), "dangling-target", "/shot/volume.field:surface"),
    "field to a mesh": (
        lambda s: UsdVol.Volume(s.GetPrimAtPath("/shot/volume")).CreateFieldRelationship("surface", BODY),
        "volume-fields",
        "/shot/volume.field:surface",
    ),
    "no field": (remove("/shot/volume", "field:surface"), "volume-fields", "/shot/volume"),
    "skin without API": (
        lambda s: s.GetPrimAtPath(SKIN).RemoveAPI(UsdSkel.BindingAPI),
        "skin-binding",
        SKIN,
    ),
    "skin without root": (lambda s: s.GetPrimAtPath("/shot/char").SetTypeName("Xform"), "skin-binding", SKIN),
    "placed nowhere": (
        lambda s: UsdGeom.Xformable(s.GetPrimAtPath("/shot/prop")).AddTranslateOp().Set(Gf.Vec3d(NAN)),
        "transform",
        "/shot/prop",
    ),
    "level set one late": (
        lambda s: [
            s.GetAttributeAtPath(f"{FIELD}.filePath").Set(Sdf.AssetPath(f"./body.{t}.vdb"), t + 1)
            for t in range(1001, 1005)
        ],
        "frame-names",
        f"{FIELD}.filePath",
    ),
    "level set of another unit": (
        lambda s: UsdGeom.Xformable(s.GetPrimAtPath("/shot/volume")).AddScaleOp().Set(Gf.Vec3f(100)),
        "volume-size",
        "/shot/volume",
    ),
    # files
    "reference missing": (lambda s: drop(s, "prop.usda"), "missing-file", "/shot/prop"),
    "level set file missing": (lambda s: drop(s, "body.1003.vdb"), "missing-file", f"{FIELD}.filePath"),
    "sublayer missing": (layer(lambda x: x.subLayerPaths.append("./gone.usda")), "missing-file", "/"),
    "absolute path": (absolute, "absolute-path", f"{FIELD}.filePath"),
    "level set broken": (vdb(1004, "broken"), "openvdb-grid", f"{FIELD}.filePath"),
    "grid missing": (vdb(1005, "density vel"), "openvdb-grid", f"{FIELD}.filePath"),
    "grid of another class": (put(FIELD, "fieldClass", "fogVolume"), "openvdb-grid", f"{FIELD}.filePath"),
}


@pytest.mark.parametrize(("plant", "rules", "paths"), DEFECTS.values(), ids=DEFECTS)
def test_names_the_defect_and_nothing_else(
    stage: Usd.Stage, found: Callable, plant: Callable, rules: str, paths: str
) -> None:
    plant(stage)
    seen = found(stage)
    assert {rule for rule, _ in seen} == set(rules.split()) and {path for _, path in seen} == set(paths.split())
