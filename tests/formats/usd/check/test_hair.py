"""Hair that nobody sees, of wrong size, unbound or wrongly moving: each planted defect is named, and nothing else."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens
HAIR, BODY, LOOK, FRAMES, COUNT = "/shot/hair", "/shot/body", "/shot/Looks/hair/surface", range(1001, 1009), 6
Plant = Callable[[Usd.Stage], object]


def edit(path: str, name: str, change: Callable[[np.ndarray], np.ndarray], *times: float) -> Plant:
    """Plant other values of an attribute, at these times, else at all it has."""

    def plant(stage: Usd.Stage) -> None:
        attribute = stage.GetAttributeAtPath(f"{path}.{name}")
        codes = [Usd.TimeCode(t) for t in times or attribute.GetTimeSamples()]
        codes += [] if times or attribute.Get() is None else [Usd.TimeCode.Default()]
        for at in codes:
            old = attribute.Get(at)
            new = np.asarray(change(np.array(old)), np.array(old).dtype)
            attribute.Set(type(old).FromNumpy(np.ascontiguousarray(new)), at)

    return plant


def boxed(plant: Plant) -> Plant:
    """Plant a defect of points, with extents that fit."""

    def both(stage: Usd.Stage) -> None:
        plant(stage)
        for path in (HAIR, BODY):
            shape = UsdGeom.Boundable(stage.GetPrimAtPath(path))
            times = [Usd.TimeCode(t) for t in shape.GetExtentAttr().GetTimeSamples()]
            for at in times:
                shape.GetExtentAttr().Set(UsdGeom.Boundable.ComputeExtentFromPlugins(shape, at), at)

    return both


def points(change: Callable[[np.ndarray], np.ndarray], *times: float, path: str = HAIR) -> Plant:
    return boxed(edit(path, "points", change, *times))


def strands(change: Callable[[np.ndarray], np.ndarray], *times: float) -> Plant:
    """Plant other strands: a change of (s, 6, 3)."""
    return points(lambda p: change(p.reshape(-1, COUNT, 3)).reshape(-1, 3), *times)


def at_frames(path: str, name: str, value: Callable[[Usd.Attribute, int], object]) -> Plant:
    """Plant values of an attribute, each made from those of all frames."""

    def plant(stage: Usd.Stage) -> None:
        attribute = stage.GetAttributeAtPath(f"{path}.{name}")
        values = [value(attribute, frame) for frame in FRAMES]
        for frame, new in zip(FRAMES, values, strict=True):
            attribute.Set(new, frame)

    return plant


def all_of(*plants: Plant) -> Plant:
    return lambda stage: [plant(stage) for plant in plants]


def put(path: str, name: str, value: object, kind: Sdf.ValueTypeName | None = None) -> Plant:
    def plant(stage: Usd.Stage) -> None:
        prim = stage.GetPrimAtPath(path)
        attribute = prim.CreateAttribute(name, kind) if kind else prim.GetAttribute(name)
        attribute.Set(value)

    return plant


def still(path: str, name: str) -> Plant:
    """Plant the value of the first frame for all."""

    def plant(stage: Usd.Stage) -> None:
        attribute = stage.GetAttributeAtPath(f"{path}.{name}")
        value = attribute.Get(FRAMES[0])
        for frame in FRAMES:
            attribute.Set(value, frame)

    return plant


def remove(path: str, name: str) -> Plant:
    return lambda stage: stage.GetPrimAtPath(path).RemoveProperty(name)


def prim(edit: Callable[[Usd.Prim], object], path: str = HAIR) -> Plant:
    return lambda stage: edit(stage.GetPrimAtPath(path))


def spec(edit: Callable[[Sdf.PrimSpec], object], path: str = HAIR) -> Plant:
    return lambda stage: edit(stage.GetRootLayer().GetPrimAtPath(path))


def meta(name: str, value: object) -> Plant:
    return lambda stage: stage.SetMetadata(name, value)


def xform(edit: Callable[[UsdGeom.Xformable], object], path: str = HAIR) -> Plant:
    return lambda stage: edit(UsdGeom.Xformable(stage.GetPrimAtPath(path)))


def copy(to: str, path: str = HAIR) -> Plant:
    return lambda stage: Sdf.CopySpec(stage.GetRootLayer(), path, stage.GetRootLayer(), to)


def ids_of(kind: Sdf.ValueTypeName, value: object) -> Plant:
    def plant(stage: Usd.Stage) -> None:
        stage.GetPrimAtPath(HAIR).RemoveProperty("primvars:hairId")
        UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(HAIR)).CreatePrimvar("hairId", kind, TOKENS.uniform).Set(value)

    return plant


def elsewhere(stage: Usd.Stage) -> None:
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/other").GetPrim())


def without_velocities(path: Path) -> None:
    layer = Sdf.Layer.FindOrOpen(str(path))
    del layer.GetPrimAtPath(HAIR).properties["velocities"]
    layer.Save()


def swings(strands: np.ndarray) -> np.ndarray:
    """Return unit offsets of points, alternately, sideways of strands, (s, 6, 3); none of the root."""
    along = strands[:, -1] - strands[:, 0]
    aside = np.cross(along, [0.3, 0.5, 0.8])
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    return aside[:, None] * np.array([0, 1, -1, 1, -1, 1])[None, :, None]


def in_doubles(stage: Usd.Stage) -> None:
    """Plant doubles in an attribute that is declared as the schema has it: what flattening makes of declared ones."""
    attribute = stage.GetAttributeAtPath(f"{HAIR}.points")
    values = {time: np.array(attribute.Get(time), np.float64) for time in attribute.GetTimeSamples()}
    stage.GetPrimAtPath(HAIR).RemoveProperty("points")
    layer = stage.GetRootLayer()
    made = Sdf.AttributeSpec(layer.GetPrimAtPath(HAIR), "points", TYPES.Point3dArray)
    for time, points in values.items():
        layer.SetTimeSample(made.path, time, Vt.Vec3dArray.FromNumpy(points))
    made.SetInfo("typeName", "point3f[]")


def rest_in_doubles(stage: Usd.Stage) -> None:
    values = np.array(stage.GetAttributeAtPath(f"{HAIR}.primvars:pref").Get(), np.float64)
    stage.GetPrimAtPath(HAIR).RemoveProperty("primvars:pref")
    api = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(HAIR))
    api.CreatePrimvar("pref", TYPES.Point3dArray, TOKENS.vertex).Set(Vt.Vec3dArray.FromNumpy(values))


def far(stage: Usd.Stage) -> None:
    """Plant points a kilometre away, and bring them back by a translate."""
    edit(HAIR, "points", lambda p: np.add(p, [1000, 0, 0]))(stage)
    boxed(lambda stage: None)(stage)
    UsdGeom.Xformable(stage.GetPrimAtPath(HAIR)).AddTranslateOp().Set(Gf.Vec3d(-1000, 0, 0))


DEFECTS: dict[str, tuple[Plant, str, str]] = {
    # seen
    "invisible": (prim(lambda p: UsdGeom.Imageable(p).MakeInvisible()), "hair-drawn", HAIR),
    "invisible from frame 5": (
        prim(lambda p: UsdGeom.Imageable(p).CreateVisibilityAttr().Set("invisible", 1005)),
        "hair-drawn",
        HAIR,
    ),
    "a guide": (prim(lambda p: UsdGeom.Imageable(p).CreatePurposeAttr("guide")), "hair-drawn", HAIR),
    "an over": (spec(lambda s: setattr(s, "specifier", Sdf.SpecifierOver)), "hair-drawn", HAIR),
    "a class": (spec(lambda s: setattr(s, "specifier", Sdf.SpecifierClass)), "hair-drawn", HAIR),
    "no type": (spec(lambda s: setattr(s, "typeName", "BasisCurve")), "hair-drawn", HAIR),
    "inactive": (prim(lambda p: p.SetActive(False)), "hair-drawn", HAIR),
    "root inactive": (prim(lambda p: p.SetActive(False), "/shot"), "hair-drawn", "/shot"),
    "default prim without hair": (elsewhere, "default-prim", "/other"),
    "doubled": (copy("/shot/again"), "doubled", "/shot/again"),
    "no strands": (
        all_of(
            edit(HAIR, "points", lambda p: p[:0]),
            edit(HAIR, "velocities", lambda p: p[:0]),
            edit(HAIR, "curveVertexCounts", lambda p: p[:0]),
            edit(HAIR, "widths", lambda p: p[:0]),
            *(edit(HAIR, f"primvars:{n}", lambda p: p[:0]) for n in ("pref", "hairId", "st", "skinprim", "skinprimuv")),
        ),
        "curve-counts widths",
        f"{HAIR}.curveVertexCounts {HAIR}.widths",
    ),
    # size
    "centimetres": (meta("metersPerUnit", 0.01), "size", "/"),
    "hundreds of metres": (meta("metersPerUnit", 100.0), "size", "/"),
    "ten metres": (meta("metersPerUnit", 10.0), "size", "/"),
    "own scale": (xform(lambda x: x.AddScaleOp().Set(Gf.Vec3f(1.2))), "hair-transform roots", f"{HAIR} {HAIR}.points"),
    "mirrored": (
        xform(lambda x: x.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))),
        "hair-transform roots",
        f"{HAIR} {HAIR}.points",
    ),
    "all mirrored": (xform(lambda x: x.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1)), "/shot"), "hair-transform", HAIR),
    "flat": (xform(lambda x: x.AddScaleOp().Set(Gf.Vec3f(1, 1, 0)), BODY), "transform roots", f"{BODY} {HAIR}.points"),
    "no width": (edit(HAIR, "widths", lambda w: 0 * w), "widths", f"{HAIR}.widths"),
    "widths of centimetres": (boxed(edit(HAIR, "widths", lambda w: 100 * w)), "size", f"{HAIR}.widths"),
    "widths of one": (boxed(edit(HAIR, "widths", lambda w: 0 * w + 1)), "size", f"{HAIR}.widths"),
    "zigzags": (strands(lambda s: s + 8e-3 * swings(s)), "zigzag", f"{HAIR}.points"),
    "points in doubles": (in_doubles, "doubles", f"{HAIR}.points"),
    "rest in doubles": (rest_in_doubles, "doubles", f"{HAIR}.primvars:pref"),
    "colours to 255": (
        put(HAIR, "primvars:displayColor", [Gf.Vec3f(23, 255, 4)]),
        "colours",
        f"{HAIR}.primvars:displayColor",
    ),
    "primvars:widths": (
        put(HAIR, "primvars:widths", [1.0], TYPES.FloatArray),
        "two-of-one",
        f"{HAIR}.primvars:widths",
    ),
    "rest in centimetres": (edit(HAIR, "primvars:pref", lambda p: 100 * p), "rest", f"{HAIR}.primvars:pref"),
    "rest of others": (
        edit(HAIR, "primvars:pref", lambda p: p * np.repeat(np.where(np.arange(30) % 3, 1, 4), 6)[:, None]),
        "rest",
        f"{HAIR}.primvars:pref",
    ),
    "far from the origin": (far, "precision", f"{HAIR}.points"),
    "moved far in single precision": (
        xform(lambda x: x.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat).Set(Gf.Vec3f(3e6, 0, 0)), "/shot"),
        "precision",
        "/shot.xformOp:translate",
    ),
    "thick tips": (
        boxed(edit(HAIR, "widths", lambda w: w * np.tile(np.linspace(0.2, 2, COUNT), 30))),
        "taper",
        f"{HAIR}.widths",
    ),
    "flickering widths": (
        lambda s: [
            s.GetAttributeAtPath(f"{HAIR}.widths").Set(Vt.FloatArray(180, 8e-5 if t % 2 else 3e-5), t) for t in FRAMES
        ],
        "widths-steady",
        f"{HAIR}.widths",
    ),
    "rounded": (points(lambda p: np.round(p / 0.001) * 0.001), "rounded", f"{HAIR}.points"),
    "another unit without a time": (
        lambda s: (a := s.GetAttributeAtPath(f"{HAIR}.points")).Set(Vt.Vec3fArray([100 * p for p in a.Get()])),
        "defaults",
        f"{HAIR}.points",
    ),
    # bound
    "roots off": (points(lambda p: np.add(p, [0.1, 0, 0])), "roots", f"{HAIR}.points"),
    "half the roots off": (
        strands(lambda s: s + (np.arange(30) % 2)[:, None, None] * [0.0, 0.03, 0]),
        "roots",
        f"{HAIR}.points",
    ),
    "left and right": (
        all_of(points(lambda p: p * [-1, 1, 1]), edit(HAIR, "velocities", lambda p: p * [-1, 1, 1])),
        "roots",
        f"{HAIR}.points",
    ),
    "reversed": (
        all_of(
            strands(lambda s: s[:, ::-1]),
            edit(HAIR, "velocities", lambda v: v.reshape(-1, COUNT, 3)[:, ::-1].reshape(-1, 3)),
        ),
        "roots rest",
        f"{HAIR}.points {HAIR}.primvars:pref",
    ),
    "placed twice": (xform(lambda x: x.AddTranslateOp().Set(Gf.Vec3d(0, 1.6, 0))), "roots", f"{HAIR}.points"),
    "faces out of range": (
        edit(HAIR, "primvars:skinprim", lambda f: f + 100),
        "skin-range",
        f"{HAIR}.primvars:skinprim",
    ),
    "faces negative": (
        edit(HAIR, "primvars:skinprim", lambda f: np.where(np.arange(30) == 3, -1, f)),
        "skin-range",
        f"{HAIR}.primvars:skinprim",
    ),
    "other faces": (
        edit(HAIR, "primvars:skinprim", lambda f: np.roll(f, 1)),
        "roots root-uv",
        f"{HAIR}.points {HAIR}.primvars:st",
    ),
    "outside of the face": (
        edit(HAIR, "primvars:skinprimuv", lambda f: np.add(f, [0, 1])),
        "skin-range roots root-uv",
        f"{HAIR}.primvars:skinprimuv {HAIR}.points {HAIR}.primvars:st",
    ),
    "st flipped": (edit(HAIR, "primvars:st", lambda f: [0, 1] + f * [1, -1]), "root-uv", f"{HAIR}.primvars:st"),
    "st constant": (edit(HAIR, "primvars:st", lambda f: 0 * f), "root-uv", f"{HAIR}.primvars:st"),
    "no ids": (remove(HAIR, "primvars:hairId"), "hair-ids", f"{HAIR}.primvars:hairId"),
    "float ids": (ids_of(TYPES.FloatArray, Vt.FloatArray(range(30))), "hair-ids", f"{HAIR}.primvars:hairId"),
    # motion
    "one frame late": (
        all_of(*(at_frames(HAIR, n, lambda a, f: a.Get(max(f - 1, 1001))) for n in ("points", "velocities", "extent"))),
        "roots velocity-match",
        f"{HAIR}.points {HAIR}.velocities",
    ),
    "body frozen": (
        all_of(*(still(BODY, n) for n in ("points", "normals", "extent")), edit(BODY, "velocities", lambda v: 0 * v)),
        "roots",
        f"{HAIR}.points",
    ),
    "hair frozen": (
        all_of(*(still(HAIR, n) for n in ("points", "extent")), edit(HAIR, "velocities", lambda v: 0 * v)),
        "roots",
        f"{HAIR}.points",
    ),
    "velocities x 0.5": (edit(HAIR, "velocities", lambda v: v / 2), "velocity-match", f"{HAIR}.velocities"),
    "velocities x 2": (edit(HAIR, "velocities", lambda v: v * 2), "velocity-match", f"{HAIR}.velocities"),
    "velocities x 1.25": (edit(HAIR, "velocities", lambda v: v * 1.25), "velocity-match", f"{HAIR}.velocities"),
    "velocities of another frame": (
        at_frames(HAIR, "velocities", lambda a, f: a.Get(min(f + 1, 1008))),
        "velocity-match",
        f"{HAIR}.velocities",
    ),
    "velocities of other strands": (
        edit(HAIR, "velocities", lambda v: np.roll(v, 45, axis=0)),
        "velocity-match",
        f"{HAIR}.velocities",
    ),
    "no velocities": (remove(HAIR, "velocities"), "velocities", f"{HAIR}.velocities"),
    "another rate": (
        all_of(meta("timeCodesPerSecond", 25.0), meta("framesPerSecond", 25.0)),
        "velocity-match",
        f"{HAIR}.velocities {BODY}.velocities",
    ),
    "wild accelerations": (
        put(HAIR, "accelerations", Vt.Vec3fArray(180, Gf.Vec3f(1000)), TYPES.Vector3fArray),
        "acceleration-match sample-times",
        f"{HAIR}.accelerations",
    ),
    "a sample beside another": (
        lambda s: [
            (a := s.GetAttributeAtPath(f"{HAIR}.{n}")).Set(a.Get(1004), 1004.004)
            for n in ("points", "velocities", "extent")
        ],
        "sample-times",
        f"{HAIR}.points",
    ),
    # strands
    "collapsed": (
        strands(lambda s: np.where(np.arange(30)[:, None, None] == 4, s[:, :1], s)),
        "collapsed",
        f"{HAIR}.points",
    ),
    "all collapsed": (
        strands(lambda s: 0 * s + s[:, :1]),
        "collapsed velocity-match",
        f"{HAIR}.points {HAIR}.velocities",
    ),
    "points on each other": (strands(lambda s: s[:, [0, 1, 1, 3, 4, 5]]), "collapsed", f"{HAIR}.points"),
    "tips at roots": (strands(lambda s: np.concatenate([s[:, :5], s[:, :1]], 1)), "stretch", f"{HAIR}.points"),
    "tips stretched by 3": (
        strands(lambda s: np.concatenate([s[:, :5], s[:, 4:5] + 3 * (s[:, 5:] - s[:, 4:5])], 1)),
        "stretch",
        f"{HAIR}.points",
    ),
    "strands grow": (
        strands(lambda s: s[:, :1] + 1.6 * (s - s[:, :1]), 1006, 1007, 1008),
        "stretch velocity-match",
        f"{HAIR}.points {HAIR}.velocities",
    ),
    # body
    "smoothed": (remove(BODY, "subdivisionScheme"), "subdivision", f"{BODY}.subdivisionScheme"),
    "normals inward": (edit(BODY, "normals", lambda n: -n), "normals", f"{BODY}.normals"),
    "faces inward": (
        all_of(
            edit(BODY, "normals", lambda n: -n),
            put(BODY, "orientation", "leftHanded"),
        ),
        "normals",
        f"{BODY}.faceVertexIndices",
    ),
    "normals of any length": (edit(BODY, "normals", lambda n: 0.1 * n), "normals", f"{BODY}.normals"),
    "other up": (meta("upAxis", "Z"), "up-axis", "/"),
    "ignored transform": (
        prim(lambda p: p.CreateAttribute("xformOp:translate", TYPES.Double3).Set(Gf.Vec3d(1, 0, 0))),
        "ignored-transform",
        f"{HAIR}.xformOp:translate",
    ),
    "reset transform": (xform(lambda x: x.SetResetXformStack(True)), "reset-transform", HAIR),
    # looks
    "unknown shader": (put(LOOK, "info:id", "UsdPreviewSurfaces"), "shader-id", LOOK),
    "no surface": (remove("/shot/Looks/hair", "outputs:surface"), "surface", "/shot/Looks/hair"),
    "transparent": (
        put(LOOK, "inputs:opacity", 0.0, TYPES.Float),
        "shader-input",
        f"{LOOK}.inputs:opacity",
    ),
    "colours of bytes": (
        put(LOOK, "inputs:diffuseColor", Gf.Vec3f(60, 40, 20), TYPES.Color3f),
        "shader-input",
        f"{LOOK}.inputs:diffuseColor",
    ),
    "not bound": (remove(HAIR, "material:binding"), "hair-material", HAIR),
    "bound for full renders": (
        prim(
            lambda p: (
                p.RemoveProperty("material:binding")
                and p.CreateRelationship("material:binding:full").SetTargets(["/shot/Looks/hair"])
            )
        ),
        "hair-material",
        HAIR,
    ),
    "looks outside": (
        lambda s: [
            copy("/Looks", "/shot/Looks")(s),
            UsdShade.MaterialBindingAPI(s.GetPrimAtPath(HAIR)).GetDirectBindingRel().SetTargets(["/Looks/hair"]),
        ],
        "target-outside",
        f"{HAIR}.material:binding",
    ),
    "unknown kind": (prim(lambda p: Usd.ModelAPI(p).SetKind("hairdo"), "/shot"), "kind", "/shot"),
}


@pytest.mark.parametrize(("plant", "rules", "paths"), DEFECTS.values(), ids=DEFECTS)
def test_names_the_defect_and_nothing_else(
    head: Usd.Stage, found: Callable, plant: Plant, rules: str, paths: str
) -> None:
    plant(head)
    seen = found(head)
    assert {rule for rule, _ in seen} == set(rules.split()) and {path for _, path in seen} == set(paths.split())


@pytest.mark.parametrize("points_a_turn", [3, 4, 7])
def test_curls_are_not_zigzags(head: Usd.Stage, found: Callable, points_a_turn: int) -> None:
    """Around every strand, to 4 mm, at rest and in motion."""
    phases = 2.0 * np.pi * np.arange(COUNT) / points_a_turn

    def curled(points: np.ndarray) -> np.ndarray:
        strands = points.reshape(-1, COUNT, 3)
        along = (strands[:, -1] - strands[:, 0]) / np.linalg.norm(strands[:, -1] - strands[:, 0], axis=1)[:, None]
        first = np.cross(along, [0.3, 0.5, 0.8])
        first /= np.linalg.norm(first, axis=1)[:, None]
        second = np.cross(along, first)
        round_it = (np.cos(phases) - 1.0)[:, None] * first[:, None] + np.sin(phases)[:, None] * second[:, None]
        return (strands + 4e-3 * round_it).reshape(-1, 3)

    points(curled)(head)
    assert "zigzag" not in {rule for rule, _ in found(head)}


def test_silent_on_the_head(head: Usd.Stage, found: Callable) -> None:
    assert found(head) == []
