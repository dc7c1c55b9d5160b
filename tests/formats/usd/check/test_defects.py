"""Each planted defect is named, at its place, and nothing else is.

A path without a leading slash lies under /shot; `SHORT` has names for parts of it, so that `.points` is an attribute of
the hair. Primvars have no prefix. A plant is a call with the stage.
"""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, UsdVol, Vt

from hairpipe.engine.file.registry import Registry
from hairpipe.formats.usd.check.causes import CAUSES, SHOT, lineage_of
from hairpipe.formats.usd.check.clients import PROGRAMS, rules_for
from hairpipe.formats.usd.check.lint import RULES, lint

TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens
FRAMES, STRANDS = range(1001, 1009), 30
SHORT = {"": "hair", "look": "Looks/hair/surface", "field": "volume/surface"}
PRIMVARS = ("pref", "hairId", "st", "skinprim", "skinprimuv", "displayColor", "lockId")
HAIR, BODY, LOOK, SURFACE = "/shot/hair", "/shot/body", "/shot/Looks/hair", "/shot/Looks/hair/surface"
Plant = Callable[[Usd.Stage], object]
Edit = Callable[[np.ndarray], np.ndarray]


def full(path: str) -> str:
    """Return a whole path from one as the tables write it."""
    prim, dot, name = path.partition(".")
    place = prim if prim.startswith("/") else f"/shot/{SHORT.get(prim, prim)}"
    return place + dot + (f"primvars:{name}" if name in PRIMVARS else name)


def attribute_of(stage: Usd.Stage, path: str) -> Usd.Attribute:
    return stage.GetAttributeAtPath(full(path))


def beside(stage: Usd.Stage, name: str) -> Path:
    """Return the path of a file in the folder of the stage."""
    return Path(stage.GetRootLayer().realPath).with_name(name)


def all_of(*plants: Plant) -> Plant:
    return lambda stage: [plant(stage) for plant in plants]


def edit(path: str, change: Edit, *times: float) -> Plant:
    """Plant other values of an attribute, at these times, else at all it has."""

    def plant(stage: Usd.Stage) -> None:
        attribute = attribute_of(stage, path)
        codes = [Usd.TimeCode(t) for t in times or attribute.GetTimeSamples()]
        codes += [] if times or attribute.Get() is None else [Usd.TimeCode.Default()]
        for at in codes:
            old = attribute.Get(at)
            new = np.asarray(change(np.array(old)), np.array(old).dtype)
            attribute.Set(type(old).FromNumpy(np.ascontiguousarray(new)), at)

    return plant


def put(path: str, value: object, kind: Sdf.ValueTypeName | None = None, time: float | None = None) -> Plant:
    """Plant a value of an attribute, which is made if a type is given."""

    def plant(stage: Usd.Stage) -> None:
        at, _, name = full(path).partition(".")
        prim = stage.GetPrimAtPath(at)
        attribute = prim.CreateAttribute(name, kind) if kind else prim.GetAttribute(name)
        attribute.Set(value, Usd.TimeCode.Default() if time is None else time)

    return plant


def at_frames(path: str, value: Callable[[Usd.Attribute, int], object]) -> Plant:
    """Plant values of an attribute, each made from those of all frames."""

    def plant(stage: Usd.Stage) -> None:
        attribute = attribute_of(stage, path)
        for frame, new in [(frame, value(attribute, frame)) for frame in FRAMES]:
            attribute.Set(new, frame)

    return plant


def still(path: str) -> Plant:
    return at_frames(path, lambda attribute, _: attribute.Get(FRAMES[0]))


def repeat(path: str, names: str, frame: float, at: float) -> Plant:
    """Plant the values of a frame at another time."""
    return all_of(*(lambda s, n=n: (a := attribute_of(s, f"{path}.{n}")).Set(a.Get(frame), at) for n in names.split()))


def forget(path: str, names: str, *times: float) -> Plant:
    """Plant a gap in the samples."""
    return lambda s: [attribute_of(s, f"{path}.{name}").ClearAtTime(t) for name in names.split() for t in times]


def remove(path: str) -> Plant:
    """Remove a property, or a prim."""
    at, _, name = full(path).partition(".")
    return lambda stage: stage.GetPrimAtPath(at).RemoveProperty(name) if name else stage.RemovePrim(at)


def boxed(plant: Plant) -> Plant:
    """Plant a defect of points, with extents that fit."""

    def both(stage: Usd.Stage) -> None:
        plant(stage)
        for path in (HAIR, BODY):
            shape = UsdGeom.Boundable(stage.GetPrimAtPath(path))
            for at in map(Usd.TimeCode, shape.GetExtentAttr().GetTimeSamples()):
                shape.GetExtentAttr().Set(UsdGeom.Boundable.ComputeExtentFromPlugins(shape, at), at)

    return both


def strands(change: Edit, *times: float, names: str = "points") -> Plant:
    """Plant other strands: a change of (s, points, 3)."""

    def changed(points: np.ndarray) -> np.ndarray:
        return change(points.reshape(STRANDS, -1, 3)).reshape(-1, 3)

    return boxed(all_of(*(edit(f".{name}", changed, *times) for name in names.split())))


def strand(change: Edit, *times: float, names: str = "points") -> Plant:
    """Plant one other strand."""

    def changed(strands: np.ndarray) -> np.ndarray:
        return np.concatenate([strands[:4], change(strands[4])[None], strands[5:]])

    return strands(changed, *times, names=names)


def swings(strands: np.ndarray) -> np.ndarray:
    """Return unit offsets of points, alternately, sideways of strands, (s, 6, 3); none of the root."""
    along = strands[:, -1] - strands[:, 0]
    aside = np.cross(along, [0.3, 0.5, 0.8])
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    return aside[:, None] * np.array([0, 1, -1, 1, -1, 1])[None, :, None]


def prim(change: Callable[[Usd.Prim], object], path: str = HAIR) -> Plant:
    return lambda stage: change(stage.GetPrimAtPath(full(path)))


def shape(change: Callable[[UsdGeom.Boundable], object], path: str = HAIR) -> Plant:
    return lambda stage: change(UsdGeom.Boundable(stage.GetPrimAtPath(full(path))))


def spec(change: Callable[[Sdf.PrimSpec], object]) -> Plant:
    return lambda stage: change(stage.GetRootLayer().GetPrimAtPath(HAIR))


def layer(change: Callable[[Sdf.Layer], object]) -> Plant:
    return lambda stage: change(stage.GetRootLayer())


def meta(**values: object) -> Plant:
    return lambda stage: [stage.SetMetadata(name, value) for name, value in values.items()]


def copy(path: str, to: str) -> Plant:
    return lambda s: Sdf.CopySpec(s.GetRootLayer(), full(path), s.GetRootLayer(), full(to))


def hide(path: str, *times: float) -> Plant:
    return shape(lambda s: [s.CreateVisibilityAttr().Set("invisible", t) for t in times or [Usd.TimeCode()]], path)


def refer(path: str, target: str = "") -> Plant:
    """Plant a reference to a prim that a file does not have."""

    def plant(stage: Usd.Stage) -> None:
        made = Usd.Stage.CreateNew(str(beside(stage, "part.usda")))
        made.DefinePrim("/prop")
        made.Save()
        stage.DefinePrim(full(path)).GetReferences().AddReference("./part.usda", target)

    return plant


def sublayer(name: str, **facts: object) -> Plant:
    """Plant a sublayer of these metadata."""

    def plant(stage: Usd.Stage) -> None:
        made = Usd.Stage.CreateNew(str(beside(stage, name)))
        for fact, value in facts.items():
            made.SetMetadata(fact, value)
        made.DefinePrim("/shot")
        made.Save()
        stage.GetRootLayer().subLayerPaths.append(f"./{name}")

    return plant


def retype(path: str, kind: Sdf.ValueTypeName, value: object) -> Plant:
    """Plant an attribute of another type than that of the schema."""

    def plant(stage: Usd.Stage) -> None:
        prim, name = stage.GetRootLayer().GetPrimAtPath(full(path).partition(".")[0]), path.partition(".")[2]
        prim.RemoveProperty(prim.properties[name])
        Sdf.AttributeSpec(prim, name, kind).default = value

    return plant


def primvar(name: str, kind: Sdf.ValueTypeName, values: object, interpolation: str = TOKENS.uniform) -> Plant:
    """Plant a primvar of the hair in place of the one of its name."""

    def plant(stage: Usd.Stage) -> None:
        stage.GetPrimAtPath(HAIR).RemoveProperty(f"primvars:{name}")
        UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(HAIR)).CreatePrimvar(name, kind, interpolation).Set(values)

    return plant


def interpolate(name: str, interpolation: str) -> Plant:
    return prim(lambda p: UsdGeom.PrimvarsAPI(p).GetPrimvar(name).SetInterpolation(interpolation))


def bind(name: str, *targets: str) -> Plant:
    """Plant a binding of the hair."""
    return prim(lambda p: p.CreateRelationship(f"material:binding{name}").SetTargets(targets))


def bind_subset(stage: Usd.Stage) -> None:
    """Plant a subset of faces that has a material, but no family."""
    subset = UsdGeom.Subset.Define(stage, f"{BODY}/scalp")
    subset.CreateIndicesAttr([0, 1])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(UsdShade.Material(stage.GetPrimAtPath(LOOK)))


def name_normals(stage: Usd.Stage) -> None:
    """Plant a normal map of 8 bits, read as a picture of colours."""
    texture = UsdShade.Shader.Define(stage, f"{LOOK}/normals")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", TYPES.Asset).Set("./normals.png")
    output = texture.CreateOutput("rgb", TYPES.Float3)
    UsdShade.Shader(stage.GetPrimAtPath(SURFACE)).CreateInput("normal", TYPES.Normal3f).ConnectToSource(output)
    beside(stage, "normals.png").touch()


def curve(counts: list[int], **tokens: str) -> Plant:
    """Plant a second, still groom of this shape."""

    def plant(stage: Usd.Stage) -> None:
        prim = UsdGeom.BasisCurves.Define(stage, "/shot/more")
        points = np.linspace(0, 1, 3 * sum(counts), dtype=np.float32).reshape(-1, 3)
        prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
        prim.CreateCurveVertexCountsAttr(counts)
        prim.CreateWidthsAttr([0.001])
        prim.SetWidthsInterpolation(TOKENS.constant)
        prim.CreateExtentAttr(UsdGeom.Curves.ComputeExtent(prim.GetPointsAttr().Get(), prim.GetWidthsAttr().Get()))
        for name, token in {"type": "cubic", "basis": "catmullRom", "wrap": "pinned", **tokens}.items():
            prim.GetPrim().GetAttribute(name).Set(token)

    return plant


def elsewhere(stage: Usd.Stage) -> None:
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/other").GetPrim())


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
    primvar("pref", TYPES.Point3dArray, Vt.Vec3dArray.FromNumpy(values), TOKENS.vertex)(stage)


def lock(leaders: Edit) -> Plant:
    """Plant which hair each follows, of its ids."""

    def plant(stage: Usd.Stage) -> None:
        ids = np.array(attribute_of(stage, ".hairId").Get())
        primvar("lockId", TYPES.IntArray, Vt.IntArray(leaders(ids).tolist()))(stage)

    return plant


def level_set(*files: str) -> Plant:
    """Plant a level set, of one file for all frames, or of a file a frame."""

    def plant(stage: Usd.Stage) -> None:
        field = UsdVol.OpenVDBAsset.Define(stage, "/shot/levelset/surface")
        UsdVol.Volume.Define(stage, "/shot/levelset").CreateFieldRelationship("surface", field.GetPath())
        for time, file in zip(FRAMES, files, strict=False):
            beside(stage, file).write_bytes(b"vdb" * 1000)
            field.CreateFilePathAttr().Set(Sdf.AssetPath(f"./{file}"), time)

    return plant


def without_faces(stage: Usd.Stage) -> None:
    """Plant a skin without every fourth of its lower faces, on which no hair stands."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(BODY))
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    roots = attribute_of(stage, ".skinprim")
    kept = np.arange(len(corners)) % 4 > 0
    kept[np.array(roots.Get())] = True
    roots.Set((np.cumsum(kept) - 1)[np.array(roots.Get())].tolist())
    mesh.GetFaceVertexCountsAttr().Set([3] * int(kept.sum()))
    mesh.GetFaceVertexIndicesAttr().Set(corners[kept].ravel().tolist())
    edit("body.st", lambda st: st.reshape(-1, 3, 2)[kept].reshape(-1, 2))(stage)


def in_variant(stage: Usd.Stage) -> None:
    """Plant hair in a variant that nothing selects."""
    layer = stage.GetRootLayer()
    stage.GetPrimAtPath("/shot").GetVariantSets().AddVariantSet("groom").AddVariant("long")
    variant = layer.GetPrimAtPath("/shot").variantSets["groom"].variants["long"].primSpec
    Sdf.CopySpec(layer, HAIR, layer, variant.path.AppendChild("hair"))
    stage.RemovePrim(HAIR)


def choose(stage: Usd.Stage) -> None:
    variants = stage.GetDefaultPrim().GetVariantSets().AddVariantSet("look")
    variants.AddVariant("wet")
    variants.SetVariantSelection("dry")


def scatter(stage: Usd.Stage) -> None:
    UsdGeom.PointInstancer.Define(stage, "/shot/scatter").CreatePrototypesRel().SetTargets([HAIR])


def add_op(name: str, *value: float, path: str = HAIR) -> Plant:
    """Plant an operation of a transform: Translate or Scale."""
    kind = Gf.Vec3d if name == "Translate" else Gf.Vec3f
    return lambda stage: getattr(UsdGeom.Xformable(stage.GetPrimAtPath(full(path))), f"Add{name}Op")().Set(kind(*value))


def shade_elsewhere(stage: Usd.Stage) -> None:
    """Add a shader of a renderer, which OpenUSD does not know."""
    shader = UsdShade.Shader.Define(stage, f"{LOOK}/arnold")
    shader.CreateIdAttr("arnold:standard_hair")
    shader.CreateInput("melanin", TYPES.Float).Set(0.9)


def instance(stage: Usd.Stage) -> None:
    """Add two instances of a cube with a material of its own."""
    made = Usd.Stage.CreateNew(str(beside(stage, "prop.usda")))
    cube = UsdGeom.Cube.Define(made, "/prop/cube").GetPrim()
    surface = UsdShade.Shader.Define(made, "/prop/look/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    look = UsdShade.Material.Define(made, "/prop/look")
    look.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", TYPES.Token))
    UsdShade.MaterialBindingAPI.Apply(cube).Bind(look)
    made.Save()
    for name in ("left", "right"):
        prim = UsdGeom.Xform.Define(stage, f"/shot/{name}")
        prim.GetPrim().GetReferences().AddReference("./prop.usda", "/prop")
        prim.GetPrim().SetInstanceable(True)
        prim.AddTranslateOp().Set(Gf.Vec3d(1.0, 0.0, 0.0))


NAN, INF = float("nan"), float("inf")
MOVES = "points velocities"
NORMALS = "usdShadeValidators:NormalMapTextureValidator."
ALL = "points velocities extent"
THIRD = (np.arange(30) % 3 > 0)[:, None, None]


def row(name: str, findings: str, plant: Plant):
    """Give a row of the tables: rules and places, in the order of rules, that a plant breaks."""
    return pytest.param(findings, plant, id=name)


SMALL: list = [
    # the stage
    row("no default prim", "default-prim /", lambda s: s.ClearDefaultPrim()),
    row("wrong default prim", "default-prim /", layer(lambda x: setattr(x, "defaultPrim", "none"))),
    row("no up axis", "up-axis /", lambda s: s.ClearMetadata("upAxis")),
    row("no units", "metres-per-unit /", lambda s: s.ClearMetadata("metersPerUnit")),
    row("negative units", "metres-per-unit /", meta(metersPerUnit=-1.0)),
    row("two frame rates", "frame-rate /", lambda s: s.SetFramesPerSecond(25)),
    row("no frame rate", "frame-rate /", layer(lambda x: x.ClearTimeCodesPerSecond())),
    row("no frame rates", "frame-rate /", layer(lambda x: (x.ClearTimeCodesPerSecond(), x.ClearFramesPerSecond()))),
    row("no range", "time-codes /", layer(lambda x: (x.ClearStartTimeCode(), x.ClearEndTimeCode()))),
    row("range backwards", "time-codes /", lambda s: s.SetEndTimeCode(1000)),
    row("endless range", "time-codes /", lambda s: s.SetEndTimeCode(INF)),
    # curves
    row("points too few", "curve-counts .curveVertexCounts", edit(".points", lambda p: p[:-1], 1003)),
    row("counts too few", "curve-counts .curveVertexCounts", edit(".curveVertexCounts", lambda n: n[:-1])),
    row("counts negative", "curve-counts .curveVertexCounts", put(".curveVertexCounts", [-5, 15, 5, 5, 5, 5])),
    row("no counts", "curve-counts .curveVertexCounts", remove(".curveVertexCounts")),
    row("one point", "curve-length more.curveVertexCounts", curve([4, 1])),
    row("no point", "curve-length more.curveVertexCounts", curve([4, 0])),
    row("line of one", "curve-length more.curveVertexCounts", curve([4, 1], type="linear", wrap="nonperiodic")),
    row("bspline", "hair-basis more.basis", curve([4], basis="bspline")),
    row("unpinned", "hair-basis more.wrap", curve([4], wrap="nonperiodic")),
    row("unknown wrap", "hair-basis .wrap, token .wrap", put(".wrap", "nailed")),
    row("no basis", "curve-length .curveVertexCounts, hair-basis .basis", remove(".basis")),
    row("no widths", "widths .widths", remove(".widths")),
    row("widths too few", "widths .widths", edit(".widths", lambda w: w[:-1])),
    row("width negative", "widths .widths", edit(".widths", lambda w: np.where(np.arange(30) == 4, -w, w))),
    row("widths varying", "widths .widths", prim(lambda p: UsdGeom.Curves(p).SetWidthsInterpolation("varying"))),
    row("ids twice", "hair-ids .hairId", edit(".hairId", lambda i: i // 2)),
    # counts and numbers
    row("NaN", "finite .points", edit(".points", lambda p: np.where(np.arange(30)[:, None] == 7, NAN, p), 1003)),
    row("infinite width", "finite .widths", edit(".widths", lambda w: np.where(np.arange(30) == 3, INF, w))),
    row("NaN rest", "finite .pref", edit(".pref", lambda p: p * NAN)),
    row("NaN velocity", "finite body.velocities", edit("body.velocities", lambda v: v * NAN, 1003)),
    row("velocities too few", "element-count .velocities", edit(".velocities", lambda v: v[:-1], 1003)),
    row("pref too few", "element-count .pref", edit(".pref", lambda p: p[:-1])),
    row("st too many", "element-count .st", edit(".st", lambda p: np.tile(p, (2, 1)))),
    row("ids too few", "element-count .hairId", edit(".hairId", lambda i: i[1:])),
    row("normals too few", "element-count body.normals", edit("body.normals", lambda n: n[:-1], 1003)),
    row("uv too few", "element-count body.st", edit("body.st", lambda p: p[:-1])),
    row("pref varying", "element-count .pref, hair-interpolation .pref", interpolate("pref", "varying")),
    row(
        "st on vertices",
        "hair-interpolation .st",
        all_of(interpolate("st", "vertex"), edit(".st", lambda p: np.tile(p, (5, 1)))),
    ),
    row("face counts", "mesh-faces body.faceVertexCounts", edit("body.faceVertexCounts", lambda n: n[:-1])),
    row("face index", "mesh-faces body.faceVertexIndices", edit("body.faceVertexIndices", lambda i: i + 1)),
    row("two corners", "mesh-faces body.faceVertexCounts", put("body.faceVertexCounts", [2, 4, 3, 3])),
    row("no extent", "extent .extent", remove(".extent")),
    row("extent too small", "extent .extent", edit(".extent", lambda e: e * 0.9, 1003)),
    row("extent without width", "extent .extent", edit(".extent", lambda e: np.add(e, [[4e-5], [-4e-5]]), 1003)),
    row("extent too large", "extent body.extent", edit("body.extent", lambda e: e * 3, 1003)),
    # motion
    row("frame missing", "sample-gaps .points", forget("hair", ALL, 1003)),
    row("last frames missing", "sample-gaps .points", forget("hair", ALL, 1004, 1005)),
    row("level set missing", "sample-gaps field.filePath", forget("field", "filePath", 1004)),
    row(
        "frames outside",
        "sample-range .points, sample-range body.points, sample-range field.filePath",
        lambda s: s.SetEndTimeCode(1004),
    ),
    row("velocity sample missing", "sample-times .velocities", forget("hair", "velocities", 1005)),
    row("extent sample missing", "extent body.extent, sample-times body.extent", forget("body", "extent", 1003)),
    row("velocities per frame", "velocity-match .velocities", edit(".velocities", lambda v: v / 24)),
    row("velocities backwards", "velocity-match .velocities", edit(".velocities", lambda v: -v)),
    row("velocities lost", "velocity-match .velocities", edit(".velocities", lambda v: 0 * v)),
    row(
        "ids change",
        "topology .hairId",
        all_of(*(put(".hairId", [n + t for n in range(6)], time=1001 + t) for t in range(5))),
    ),
    row(
        "strands change",
        "topology .curveVertexCounts",
        all_of(*(put(".curveVertexCounts", [5 + t, 5 - t, 5, 5, 5, 5], time=1001 + t) for t in (0, 1))),
    ),
    # prims
    row("shape under shape", "nested-gprim hair/child", lambda s: s.DefinePrim("/shot/hair/child", "Cube")),
    row(
        "component in a component",
        "kind prop",
        all_of(*(prim(lambda p: Usd.ModelAPI(p).SetKind("component"), path) for path in ("/shot", "prop"))),
    ),
    row("double widths", "attribute-type .widths", retype(".widths", TYPES.DoubleArray, Vt.DoubleArray(30, 8e-5))),
    row("binding without API", "material-binding hair", prim(lambda p: p.RemoveAPI(UsdShade.MaterialBindingAPI))),
    row("binding to nothing", "dangling-target .material:binding", bind("", "/shot/Looks/gone")),
    row("binding to a mesh", "material-binding .material:binding", bind("", BODY)),
    row("shader without id", "shader-id look", remove("look.info:id")),
    row("surface to nothing", "dangling-target Looks/hair.outputs:surface", remove("look")),
    row("field to nothing", "dangling-target volume.field:surface", remove("field")),
    row(
        "field to a mesh",
        "volume-fields volume.field:surface",
        prim(lambda p: UsdVol.Volume(p).CreateFieldRelationship("surface", BODY), "volume"),
    ),
    row("no field", "volume-fields volume", remove("volume.field:surface")),
    row("skin without API", "skin-binding char/skin", prim(lambda p: p.RemoveAPI(UsdSkel.BindingAPI), "char/skin")),
    row("skin without root", "skin-binding char/skin", prim(lambda p: p.SetTypeName("Xform"), "char")),
    row("placed nowhere", "transform prop", add_op("Translate", NAN, path="prop")),
    row(
        "level set one late",
        "frame-names field.filePath",
        all_of(*(put("field.filePath", Sdf.AssetPath(f"./body.{t}.vdb"), time=t + 1) for t in range(1001, 1005))),
    ),
    row("level set of another unit", "volume-size volume", add_op("Scale", 100, path="volume")),
    # files
    row("reference missing", "missing-file prop", lambda s: beside(s, "prop.usda").unlink()),
    row("level set file missing", "missing-file field.filePath", lambda s: beside(s, "body.1003.vdb").unlink()),
    row("sublayer missing", "missing-file /", layer(lambda x: x.subLayerPaths.append("./gone.usda"))),
    row(
        "absolute path",
        "absolute-path field.filePath",
        lambda s: put("field.filePath", Sdf.AssetPath(str(beside(s, "body.1002.vdb"))), time=1002)(s),
    ),
    row("level set broken", "openvdb-grid field.filePath", lambda s: beside(s, "body.1004.vdb").write_text("broken")),
    row("grid missing", "openvdb-grid field.filePath", lambda s: beside(s, "body.1005.vdb").write_text("density vel")),
    row("grid of another class", "openvdb-grid field.filePath", put("field.fieldClass", "fogVolume")),
]
"""Defects of a stage with hair, a level set, a character and a prop: name, findings, plant."""

HEAD: list = [
    # seen
    row("invisible", "hair-drawn hair", hide("hair")),
    row("invisible from frame 5", "hair-drawn hair", hide("hair", 1005)),
    row("a guide", "hair-drawn hair", shape(lambda s: s.CreatePurposeAttr("guide"))),
    row("an over", "hair-drawn hair", spec(lambda s: setattr(s, "specifier", Sdf.SpecifierOver))),
    row("a class", "hair-drawn hair", spec(lambda s: setattr(s, "specifier", Sdf.SpecifierClass))),
    row("no type", "hair-drawn hair", spec(lambda s: setattr(s, "typeName", "BasisCurve"))),
    row("another kind of curves", "hair-drawn hair", prim(lambda p: p.SetTypeName("NurbsCurves"))),
    row("inactive", "hair-drawn hair", prim(lambda p: p.SetActive(False))),
    row("root inactive", "hair-drawn /shot", prim(lambda p: p.SetActive(False), "/shot")),
    row("in a variant that nothing selects", "hair-drawn /shot", in_variant),
    row("default prim without hair", "default-prim /other", elsewhere),
    row("doubled", "doubled again", copy("hair", "again")),
    row("scattered", "instanced-hair hair", scatter),
    row(
        "no strands",
        "curve-counts .curveVertexCounts, widths .widths",
        all_of(
            *(edit(f".{n}", lambda p: p[:0]) for n in ("points", "velocities", "curveVertexCounts", "widths")),
            *(edit(f".{n}", lambda p: p[:0]) for n in ("pref", "hairId", "st", "skinprim", "skinprimuv")),
        ),
    ),
    # size
    row("centimetres", "size /", meta(metersPerUnit=0.01)),
    row("hundreds of metres", "size /", meta(metersPerUnit=100.0)),
    row("ten metres", "size /", meta(metersPerUnit=10.0)),
    row("own scale", "hair-transform hair, roots .points", add_op("Scale", 1.2)),
    row("mirrored", "hair-transform hair, roots .points", add_op("Scale", -1, 1, 1)),
    row("all mirrored", "hair-transform hair", add_op("Scale", -1, 1, 1, path="/shot")),
    row("flat", "roots .points, transform body", add_op("Scale", 1, 1, 0, path="body")),
    row("no width", "widths .widths", edit(".widths", lambda w: 0 * w)),
    row("widths of centimetres", "size .widths", boxed(edit(".widths", lambda w: 100 * w))),
    row("widths of one", "size .widths", boxed(edit(".widths", lambda w: 0 * w + 1))),
    row(
        "one strand thick",
        "extent .extent, widths-uneven .widths",
        edit(".widths", lambda w: np.where(np.arange(len(w)) < 6, 50 * w, w)),
    ),
    row("gaps", "widths-uneven .widths", edit(".widths", lambda w: w * (np.arange(len(w)) % 6 != 2))),
    row("thick tips", "taper .widths", boxed(edit(".widths", lambda w: w * np.tile(np.linspace(0.2, 2, 6), 30)))),
    row(
        "flickering widths",
        "widths-steady .widths",
        all_of(*(put(".widths", Vt.FloatArray(180, 8e-5 if t % 2 else 3e-5), time=t) for t in FRAMES)),
    ),
    row("zigzags", "zigzag .points", strands(lambda s: s + 8e-3 * swings(s))),
    row("points in doubles", "doubles .points", in_doubles),
    row("rest in doubles", "doubles .pref", rest_in_doubles),
    row("colours to 255", "colours .displayColor", put(".displayColor", [Gf.Vec3f(23, 255, 4)])),
    row("primvars:widths", "two-of-one .primvars:widths", put(".primvars:widths", [1.0], TYPES.FloatArray)),
    row("no rest", "rest .pref", remove(".pref")),
    row("rest in centimetres", "rest .pref", edit(".pref", lambda p: 100 * p)),
    row(
        "rest of other lengths",
        "rest .pref",
        edit(".pref", lambda p: p * np.repeat(np.where(np.arange(30) % 3, 1, 4), 6)[:, None]),
    ),
    row("rest of others", "rest .pref", edit(".pref", lambda p: np.roll(p, 6 * 11, axis=0))),
    row("rest mirrored", "rest .pref", edit(".pref", lambda p: p * [-1, 1, 1])),
    row("rest upside down", "rest .pref", edit(".pref", lambda p: p.reshape(30, -1, 3)[:, ::-1].reshape(-1, 3))),
    row(
        "far from the origin",
        "precision .points",
        all_of(strands(lambda s: np.add(s, [1000, 0, 0])), add_op("Translate", -1000, 0, 0)),
    ),
    row(
        "moved far in single precision",
        "precision /shot.xformOp:translate",
        shape(lambda s: s.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat).Set(Gf.Vec3f(3e6, 0, 0)), "/shot"),
    ),
    row("rounded", "rounded .points", strands(lambda s: np.round(s / 0.001) * 0.001)),
    row(
        "another unit without a time",
        "defaults .points",
        lambda s: (a := attribute_of(s, ".points")).Set(Vt.Vec3fArray([100 * p for p in a.Get()])),
    ),
    # bound
    row("roots off", "roots .points", strands(lambda s: np.add(s, [0.1, 0, 0]))),
    row("half off", "roots .points", strands(lambda s: s + (np.arange(30) % 2)[:, None, None] * [0.0, 0.03, 0])),
    row("left and right", "roots .points", strands(lambda s: s * [-1, 1, 1], names=MOVES)),
    row("reversed", "rest .pref, roots .points", strands(lambda s: s[:, ::-1], names=MOVES)),
    row("one reversed", "roots .points", strand(lambda s: s[::-1], names=MOVES)),
    row("two swapped", "roots .points", strands(lambda s: s[[0, 1, 2, 7, 4, 5, 6, 3, *range(8, 30)]], names=MOVES)),
    row(
        "one elsewhere for a frame",
        "roots .points, strand-jumps .points, velocity-match .velocities",
        strand(lambda s: s + 0.5, 1004),
    ),
    row("placed twice", "roots .points", add_op("Translate", 0, 1.6, 0)),
    row("faces out of range", "skin-range .skinprim", edit(".skinprim", lambda f: f + 100)),
    row("faces negative", "skin-range .skinprim", edit(".skinprim", lambda f: np.where(np.arange(30) == 3, -1, f))),
    row("other faces", "root-uv .st, roots .points", edit(".skinprim", lambda f: np.roll(f, 1))),
    row(
        "outside",
        "root-uv .st, roots .points, skin-range .skinprimuv",
        edit(".skinprimuv", lambda f: np.add(f, [0, 1])),
    ),
    row("st flipped", "root-uv .st", edit(".st", lambda f: [0, 1] + f * [1, -1])),
    row("st constant", "root-uv .st", edit(".st", lambda f: 0 * f)),
    row("no ids", "hair-ids .hairId", remove(".hairId")),
    row("float ids", "hair-ids .hairId", primvar("hairId", TYPES.FloatArray, Vt.FloatArray(range(30)))),
    # motion
    row(
        "one frame late",
        "roots .points, velocity-match .velocities",
        all_of(*(at_frames(f".{n}", lambda a, f: a.Get(max(f - 1, 1001))) for n in ALL.split())),
    ),
    row(
        "body frozen",
        "roots .points",
        all_of(
            still("body.points"), still("body.normals"), still("body.extent"), edit("body.velocities", lambda v: 0 * v)
        ),
    ),
    row("frozen", "roots .points", all_of(still(".points"), still(".extent"), edit(".velocities", lambda v: 0 * v))),
    row("velocities x 0.5", "velocity-match .velocities", edit(".velocities", lambda v: v / 2)),
    row("velocities x 2", "velocity-match .velocities", edit(".velocities", lambda v: v * 2)),
    row("velocities x 1.25", "velocity-match .velocities", edit(".velocities", lambda v: v * 1.25)),
    row(
        "velocities of another frame",
        "velocity-match .velocities",
        at_frames(".velocities", lambda a, f: a.Get(min(f + 1, 1008))),
    ),
    row("velocities of others", "velocity-match .velocities", edit(".velocities", lambda v: np.roll(v, 45, axis=0))),
    row("one backwards", "velocity-match .velocities", strand(lambda s: -s, names="velocities")),
    row("a third without velocities", "velocity-match .velocities", strands(lambda s: s * THIRD, names="velocities")),
    row(
        "a third without velocities for a frame",
        "velocity-match .velocities",
        strands(lambda s: s * THIRD, 1004, names="velocities"),
    ),
    row("no velocities", "velocities .velocities", remove(".velocities")),
    row("no velocities of the body", "velocities body.velocities", remove("body.velocities")),
    row(
        "another rate",
        "velocity-match .velocities, velocity-match body.velocities",
        meta(timeCodesPerSecond=25.0, framesPerSecond=25.0),
    ),
    row(
        "wild accelerations",
        "acceleration-match .accelerations, sample-times .accelerations",
        put(".accelerations", Vt.Vec3fArray(180, Gf.Vec3f(1000)), TYPES.Vector3fArray),
    ),
    row("a sample beside another", "sample-times .points", repeat("hair", ALL, 1004, 1004.004)),
    row(
        "a frame twice",
        "velocity-match .velocities, velocity-match body.velocities",
        all_of(repeat("hair", ALL, 1004, 1005), repeat("body", ALL, 1004, 1005)),
    ),
    # strands
    row("collapsed", "collapsed .points", strand(lambda s: 0 * s + s[:1])),
    row("all collapsed", "collapsed .points, velocity-match .velocities", strands(lambda s: 0 * s + s[:, :1])),
    row("points on each other", "collapsed .points", strands(lambda s: s[:, [0, 1, 1, 3, 4, 5]])),
    row("tips at roots", "stretch .points", strands(lambda s: s[:, [0, 1, 2, 3, 4, 0]])),
    row(
        "tips stretched by 3",
        "stretch .points",
        strands(lambda s: np.concatenate([s[:, :5], s[:, 4:5] + 3 * (s[:, 5:] - s[:, 4:5])], 1)),
    ),
    row("one tip far away", "rest .pref, spike .points, stretch .points", strand(lambda s: s + np.eye(6)[5][:, None])),
    row(
        "strands grow",
        "stretch .points, velocity-match .velocities",
        strands(lambda s: s[:, :1] + 1.6 * (s - s[:, :1]), 1006, 1007, 1008),
    ),
    # body and locks
    row("no body", "body-drawn body", remove("body")),
    row("body inactive", "body-drawn body", prim(lambda p: p.SetActive(False), "body")),
    row("body invisible", "body-drawn body", hide("body")),
    row("body invisible beside another mesh", "body-drawn body", all_of(copy("body", "prop"), hide("body"))),
    row(
        "body invisible from frame 4, of another program",
        "body-drawn body",
        all_of(layer(lambda x: x.ClearCustomLayerData()), hide("body", 1004)),
    ),
    row(
        "ids reversed",
        "lock-ids .lockId",
        all_of(lock(lambda ids: ids - (ids - 100) % 3), edit(".hairId", lambda ids: ids[::-1])),
    ),
    row("locks of no hair", "lock-ids .lockId", lock(lambda ids: ids + 1)),
    row("smoothed", "subdivision body.subdivisionScheme", remove("body.subdivisionScheme")),
    row("normals inward", "normals body.normals", edit("body.normals", lambda n: -n)),
    row("normals all upward", "normals body.normals", edit("body.normals", lambda n: 0 * n + [0, 1, 0])),
    row(
        "faces inward",
        "normals body.faceVertexIndices",
        all_of(edit("body.normals", lambda n: -n), put("body.orientation", "leftHanded")),
    ),
    row("normals of any length", "normals body.normals", edit("body.normals", lambda n: 0.1 * n)),
    row("declared holes", "holes body.holeIndices", put("body.holeIndices", [0, 5, 10])),
    row("missing faces", "holes body.faceVertexIndices", without_faces),
    row("other up", "up-axis /", meta(upAxis="Z")),
    row(
        "ignored transform",
        "ignored-transform .xformOp:translate",
        put(".xformOp:translate", Gf.Vec3d(1, 0, 0), TYPES.Double3),
    ),
    row("reset transform", "reset-transform hair", shape(lambda s: s.SetResetXformStack(True))),
    row(
        "one level set",
        "openvdb-grid levelset/surface.filePath, volume-still levelset/surface.filePath",
        level_set("a.vdb"),
    ),
    row(
        "level sets of one content",
        "openvdb-grid levelset/surface.filePath, volume-still levelset/surface.filePath",
        level_set(*(f"a.{n}.vdb" for n in FRAMES)),
    ),
    # looks
    row("unknown shader", "shader-id look", put("look.info:id", "UsdPreviewSurfaces")),
    row("no surface", "surface Looks/hair", remove("Looks/hair.outputs:surface")),
    row("transparent", "shader-input look.inputs:opacity", put("look.inputs:opacity", 0.0, TYPES.Float)),
    row(
        "colours of bytes",
        "shader-input look.inputs:diffuseColor",
        put("look.inputs:diffuseColor", Gf.Vec3f(60, 40, 20), TYPES.Color3f),
    ),
    row(
        "roughness as a colour",
        "shader-input look.inputs:roughness",
        retype("look.inputs:roughness", TYPES.Color3f, Gf.Vec3f(0.4)),
    ),
    row(
        "roughness in words",
        "shader-input look.inputs:roughness",
        retype("look.inputs:roughness", TYPES.String, "rough"),
    ),
    row(
        "normal map as colours",
        f"{NORMALS}InvalidSourceColorSpace look, {NORMALS}NonCompliantBiasAndScale look",
        name_normals,
    ),
    row("not bound", "hair-material hair", remove(".material:binding")),
    row("bound for full renders", "hair-material hair", all_of(remove(".material:binding"), bind(":full", LOOK))),
    row("looks outside", "target-outside .material:binding", all_of(copy("Looks", "/Looks"), bind("", "/Looks/hair"))),
    row("binding of previews to a mesh", "material-binding .material:binding:preview", bind(":preview", BODY)),
    row("binding of previews to nothing", "dangling-target .material:binding:preview", bind(":preview", "/gone")),
    row("collection", "material-binding .material:binding:collection:all", bind(":collection:all", BODY)),
    row(
        "binding that is an attribute",
        "material-binding .material:binding:full",
        put(".material:binding:full", LOOK, TYPES.String),
    ),
    row(
        "subset of no family",
        "usdShadeValidators:SubsetMaterialBindFamilyName.MissingFamilyNameOnGeomSubset body/scalp",
        bind_subset,
    ),
    row("unknown kind", "kind /shot", prim(lambda p: Usd.ModelAPI(p).SetKind("hairdo"), "/shot")),
    # layers
    row("another unit", "layer-units /", sublayer("cm.usda", metersPerUnit=0.01)),
    row("another up", "layer-units /", sublayer("z.usda", upAxis="Z")),
    row("another rate of a layer", "layer-units /", sublayer("rate.usda", timeCodesPerSecond=30.0)),
    row("no such prim", "composition prop", refer("prop", "/prop/hair")),
    row("no default prim of a reference", "composition prop", refer("prop")),
    row("no such variant", "variant /shot", choose),
    row(
        "backslashes",
        "absolute-path prop, missing-file prop",
        lambda s: s.DefinePrim("/shot/prop").GetPayloads().AddPayload(".\\prop.usda"),
    ),
]
"""Defects of a head with hair in motion: name, findings, plant."""

GOOD: dict[str, Plant] = {
    "as it is": lambda s: None,
    "hair alone, of another program": all_of(remove("body"), layer(lambda x: x.ClearCustomLayerData())),
    "far away, by a translate in double precision": add_op("Translate", 1e5, 0, -3e4, path="/shot"),
    "centimetres": all_of(meta(metersPerUnit=0.01), add_op("Scale", 100, path="/shot")),
    "Z up": all_of(meta(upAxis="Z"), shape(lambda s: s.AddRotateXOp().Set(90), "/shot")),
    "guides beside": all_of(copy("hair", "guides"), shape(lambda s: s.CreatePurposeAttr("guide"), "guides")),
    "constant width": all_of(
        put(".widths", [8e-5]), prim(lambda p: UsdGeom.Curves(p).SetWidthsInterpolation("constant"))
    ),
    "thin tips": put(".widths", [8e-5, 8e-5, 7e-5, 6e-5, 3e-5, 0] * 30),
    "no groom": all_of(*(remove(f".{n}") for n in ("pref", "st", "skinprim", "skinprimuv"))),
    "locks": lock(lambda ids: ids - (ids - 100) % 3),
    "a hidden scalp inside a drawn head": all_of(copy("body", "scalp"), hide("scalp")),
    "a shader of a renderer": shade_elsewhere,
    "instances": instance,
}
"""Heads without a defect: name and plant."""


def listed(findings: str) -> list[tuple[str, str]]:
    """Return the rules and places of a row."""
    return sorted((rule, full(path)) for rule, path in (finding.split() for finding in findings.split(", ")))


@pytest.mark.parametrize(("findings", "plant"), SMALL)
def test_names_the_defect_of_a_stage_and_nothing_else(stage, found, findings, plant):
    plant(stage)
    assert sorted(found(stage)) == listed(findings)


@pytest.mark.parametrize(("findings", "plant"), HEAD)
def test_names_the_defect_of_a_head_and_nothing_else(head, found, findings, plant):
    plant(head)
    assert sorted(found(head)) == listed(findings)


def rewired(node: str, socket: str, source: str) -> Plant:
    """Plant another source of an input in the graph that the head states."""

    def plant(stage: Usd.Stage) -> None:
        key = f"hairpipe:nodes:{node}"
        fields = json.loads(stage.GetDefaultPrim().GetCustomDataByKey(key))
        stage.GetDefaultPrim().SetCustomDataByKey(key, json.dumps(fields | {"in": fields["in"] | {socket: source}}))

    return plant


LATER = "write nothing in the graph: usd writes this right, and the file was changed later; publish it again"
LEAP = strands(lambda s: s + np.where(np.arange(30) == 4, 3.0, 0.0)[:, None, None], *range(1005, 1009))
CAUSED: list = [
    row(
        "bspline",
        'hair-basis .basis from usd.curve = "bspline": write usd.curve = "catmull_rom"',
        put(".basis", "bspline"),
    ),
    row(
        "stretched",
        "stretch .points from hair.strain.tolerance = absent, hair.steps.longest = 0.02: write hair.strain.tolerance",
        strands(lambda s: s[:, :1] + 2 * (s - s[:, :1]), 1004),
    ),
    row("no width", "widths .widths from usd.hairs = 900: write usd.hairs", edit(".widths", lambda w: 0 * w)),
    row(
        "in centimetres",
        "size / from head.unit = 0.01, head.up = absent: write head.unit",
        meta(metersPerUnit=0.01),
    ),
    row("rest of another unit", "rest .pref from groom.unit = absent", edit(".pref", lambda p: 100 * p)),
    row("a leap", "strand-jumps .points from cuts = []: write cuts = [1005]", LEAP),
    row(
        "holes",
        "holes body.holeIndices from head.file = bytes 4f4f4f4f: write another head.file",
        put("body.holeIndices", [0, 1], TYPES.IntArray),
    ),
    row(
        "another body",
        'roots .points from usd.in.body = "other", hair.in.body = "head": write usd.in.body = "head"',
        all_of(rewired("usd", "body", "other"), strands(lambda s: np.add(s, [0.1, 0, 0]))),
    ),
    row(
        "another groom",
        'rest .pref from usd.in.groom = "dense", hair.in.groom = "groom": write usd.in.groom = "groom"',
        all_of(rewired("usd", "groom", "dense"), edit(".pref", lambda p: 100 * p)),
    ),
    row("box", f"extent .extent {LATER}", remove(".extent")),
    row("units", f"metres-per-unit / {LATER}", meta(metersPerUnit=-1.0)),
]
"""Defects of a head whose graph is in its metadata: rule, place, and the cause that is named; plant."""


@pytest.mark.parametrize(("expected", "plant"), CAUSED)
def test_names_the_setting_that_caused_a_defect(head, expected, plant):
    plant(head)
    head.Save()
    rule, place, cause = expected.split(" ", 2)
    found = {(f.rule, f.path): str(f.cause) for f in lint(beside(head, "shot.usdc"))}
    assert found[rule, full(place)].startswith(cause)


@pytest.mark.parametrize(("findings", "plant"), HEAD)
def test_every_finding_of_a_stated_graph_has_a_cause(head, findings, plant):
    plant(head)
    head.Save()
    assert all(f.cause for f in lint(beside(head, "shot.usdc")) if not f.path.startswith("/other"))


def test_every_row_of_causes_names_a_rule_and_settings_that_exist():
    rules = {rule.name for rule in (*RULES, *(rule for name in PROGRAMS for rule in rules_for(name)))}
    assert set(CAUSES) <= rules
    registry = Registry(Path("/none"))
    for rows in CAUSES.values():
        for row in (row for row in rows if row.types != (SHOT,)):
            for setting in row.settings:
                types = [registry.find(name) for name in row.types]
                assert any(setting.partition(".")[0] in node.settings for node in types), (row.types, setting)


def test_the_graph_is_found_over_references_and_in_flattened_stages(head, tmp_path):
    head.Save()
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    stage.DefinePrim("/scene/left").GetReferences().AddReference("./shot.usdc")
    stage.Save()
    stage.Flatten().Export(str(tmp_path / "flat.usda"))
    for name in ("scene.usda", "flat.usda"):
        lineage = lineage_of(Usd.Stage.Open(str(tmp_path / name)), "/scene/left/hair.points")
        assert lineage is not None and (lineage.node, lineage.key) == ("usd", "ab" * 20)
        assert lineage.upstream("hair") == ["usd", "hair", "head", "groom"]
    assert lineage_of(Usd.Stage.Open(str(tmp_path / "scene.usda")), "/scene") is None


@pytest.mark.parametrize("damage", ["nodes", "shot", "key", "{", "[]", '{"usd": 3}', '{"in": {"a": 1}}', "[" * 100_000])
def test_damaged_metadata_state_no_graph(head, damage):
    prim = head.GetDefaultPrim()
    if damage in ("nodes", "shot", "key"):
        prim.ClearCustomDataByKey(f"hairpipe:{damage}")
    else:
        prim.SetCustomDataByKey("hairpipe:nodes:usd", damage)
    head.Save()
    assert lineage_of(head) is None and lint(beside(head, "shot.usdc")) == []


@pytest.mark.parametrize("plant", GOOD.values(), ids=GOOD)
def test_silent_on_good_heads(head, found, plant):
    plant(head)
    assert found(head) == []


def test_silent_on_widths_that_end_at_0_and_on_hair_in_a_selected_variant(head, found):
    edit(".widths", lambda w: w * (np.arange(len(w)) % 6 != 5))(head)
    in_variant(head)
    head.GetPrimAtPath("/shot").GetVariantSet("groom").SetVariantSelection("long")
    assert not {"hair-drawn", "widths-uneven"} & {rule for rule, _ in found(head)}


@pytest.mark.parametrize("points_a_turn", [3, 4, 7])
def test_curls_are_not_zigzags(head, found, points_a_turn):
    """Around every strand, to 4 mm, at rest and in motion."""
    phases = 2.0 * np.pi * np.arange(6) / points_a_turn

    def curled(strands: np.ndarray) -> np.ndarray:
        along = (strands[:, -1] - strands[:, 0]) / np.linalg.norm(strands[:, -1] - strands[:, 0], axis=1)[:, None]
        first = np.cross(along, [0.3, 0.5, 0.8])
        first /= np.linalg.norm(first, axis=1)[:, None]
        second = np.cross(along, first)
        round_it = (np.cos(phases) - 1.0)[:, None] * first[:, None] + np.sin(phases)[:, None] * second[:, None]
        return strands + 4e-3 * round_it

    strands(curled)(head)
    assert "zigzag" not in {rule for rule, _ in found(head)}
