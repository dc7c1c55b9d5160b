"""A shot: simulated hair and the body under it, as one file or as one value clip per frame; or a shape at one frame.

Grooms for other programs, too: hair and guides with the names, types, units and axes that each of them reads.

The schema is the common subset of renderers: Catmull-Rom curves, by default, interpolate the simulated points, `pinned`
keeps the root on the skin in every client, and all clients read widths on vertices. Points are relative to the origin
of the world, in single precision: a kilometre away their errors are up to 0.03 mm. The level set of the body is a
volume, with fields in OpenVDB files next to the stage, one per frame.

Unreal reads primvars named groom_*, of the types int, float, float2, float3 and string alone, on curves with GroomAPI
(USDGroomConversion.cpp); it draws no guides, and takes points as they are. Houdini deforms hair by guides with the
primvar `rest`. Blender imports curves of purpose guide only on request.
"""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdUtils, UsdVol, Vt

from hairpipe import __version__
from hairpipe.errors import BadInput
from hairpipe.formats.groom_shot import DIAMETER, GroomShot
from hairpipe.formats.usd.curves import GUIDED, KNOWN
from hairpipe.formats.usd.stage import NOTES, create_stage
from hairpipe.values import Groom, Mesh, Strands
from hairpipe.values.groom import DIAMETERS, drawn_widths, labels_of
from hairpipe.values.hair import HairState
from hairpipe.values.triangles import vertex_normals

TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens
ALWAYS = Usd.TimeCode.Default()
NAMED = 5  # number of strands or vertices in a message
PENDING = 1 << 24  # bytes of samples in memory before they are saved, so that memory does not grow with the shot
BASES = {"catmull_rom": TOKENS.catmullRom, "bspline": TOKENS.bspline}
"""Bases of the curves, by the name of the setting."""
FIELDS = {"surface": ("float", "levelSet"), "vel": ("float3", "")}
"""Grids of a file of a level set, their type and class."""
HAIR = ("hair", Gf.Vec3f(0.09, 0.045, 0.013), 0.4, 1.55)
"""Name, colour, roughness and index of refraction of brown hair in bulk.

Eumelanin 0.4 absorbs 0.4 (0.419, 0.697, 1.37) [d'Eon et al. 2011], which makes this the colour of a mass of hair,
exp(-5.89 sqrt(absorption)) [Chiang et al. 2016, azimuthal roughness 0.3].
"""
SKIN = ("skin", Gf.Vec3f(0.6, 0.4, 0.33), 0.6, 1.4)


@dataclass(frozen=True)
class VolumeFile:
    """An OpenVDB file with the grids `surface` and `vel`, in metres.

    path  where it lies now
    box   lower and upper corner of its active voxels [m]
    """

    path: Path
    box: tuple[tuple[float, ...], tuple[float, ...]]


@dataclass(frozen=True)
class Followers:
    """Strands that a reader of the file deforms by its hair, which is guides; see docs/howto/guides.md.

    groom    all strands; those of the hair are its keys
    keys     the keys, in the order of the hair
    places   places of the guides of every strand in the hair, (S, k)
    weights  weights of these guides, (S, k)
    rest     points that the guides rotate [m], (p, 3)
    """

    groom: Groom
    keys: Groom
    places: np.ndarray
    weights: np.ndarray
    rest: np.ndarray


@dataclass(frozen=True)
class Shot:
    """Contents of the file; frame numbers are time codes.

    hair   hair at every frame, with constant strands and order
    body   body at the same frames, with constant triangles
    groom  groom of the hair: rest positions, ids, bindings of the roots
    fps    frames per second [1/s]
    name   of the root prim, and of the clips
    levelsets  level sets of the body, at the same frames
    states  states of the simulation at the same frames, for hair in locks: guides are written
    simulated  hairs that are not interpolated, (S,) bool; None: all, without a mark
    curve  type of the curves: through the points of the hair, or with them as control points
    cuts  frames at which the shot is cut, noted for the lint
    hairs  number of hairs that the strands represent in a picture; None: widths are diameters
    notes  metadata of the root prim, see `noted`
    followers  strands that follow the hair, written at rest; None: none
    """

    hair: Mapping[int, Strands]
    body: Mapping[int, Mesh] | None
    groom: Groom | None
    fps: float
    name: str = "shot"
    levelsets: Mapping[int, VolumeFile] | None = None
    states: Mapping[int, HairState] | None = None
    simulated: np.ndarray | None = None
    curve: Literal["catmull_rom", "bspline"] = "catmull_rom"
    cuts: tuple[int, ...] = ()
    hairs: int | None = None
    notes: Mapping[str, Any] | None = None
    followers: Followers | None = None


@dataclass(frozen=True)
class Frame:
    """Hair and body at one frame.

    hair       with the widths of a picture
    diameters  of the hair at its points where widths are others, (p,) [m]
    locks      ids of the guides of strands, those of simulated ones their own, (S,)
    """

    hair: Strands
    diameters: np.ndarray | None
    body: Mesh | None
    locks: np.ndarray | None


def noted(node: str, key: str, shot: Mapping[str, Any], nodes: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the origin of a file, see `hairpipe.engine.Origin`, as metadata of its root prim; empty without a node.

    They are composed over references, and kept where a stage is flattened. Tables are texts in JSON.
    """
    tables = {name: _table(fields) for name, fields in nodes.items()}
    return {"version": __version__, "node": node, "key": key, "shot": _table(shot), "nodes": tables} if node else {}


def _table(values: Mapping[str, Any]) -> str:
    return json.dumps(values, sort_keys=True)


def write_shot(path: Path, shot: Shot) -> dict[str, Path]:
    """Write the shot to one crate file, and level sets next to it.

    Returns the files next to it by the names, relative to the file, under which it refers to them.

    Raises BadInput if points are not finite, or strands or triangles change from frame to frame.
    """
    first = _first_frame(shot)
    stage = _begin_shot(path, shot, first)
    _hold(stage, stage.GetDefaultPrim().GetPath(), first)
    pending = 0
    for frame in shot.hair:
        pending += _sample(stage, frame, _load(shot, frame), first)
        if pending > PENDING:
            stage.Save()
            pending = 0
    return _finish(stage, shot)


def write_clips(path: Path, shot: Shot) -> dict[str, Path]:
    """Write constant values to a crate file, and each frame to a value clip of its own next to it.

    Returns these and the level sets by the names, relative to the file, under which it refers to them.

    Raises BadInput as `write_shot` does.
    """
    first = _first_frame(shot)
    folder = f"{shot.name}.clips"
    manifest = f"{folder}/{shot.name}.manifest.usdc"
    clips = {f"{folder}/{shot.name}.{frame:04d}.usdc": frame for frame in shot.hair}
    (path.parent / folder).mkdir()
    for name, frame in clips.items():
        clip = _begin_stage(path.parent / name, shot, first)
        _sample(clip, frame, _load(shot, frame), first)
        clip.Save()
    _begin_stage(path.parent / manifest, shot, first).Save()
    stage = _begin_shot(path, shot, first)
    api = Usd.ClipsAPI(stage.GetDefaultPrim())
    api.SetClipPrimPath(str(api.GetPath()))
    # No template, since a run may skip frames; the time of a clip is that of the stage.
    api.SetClipAssetPaths(Sdf.AssetPathArray([Sdf.AssetPath(f"./{name}") for name in clips]))
    api.SetClipActive([(frame, index) for index, frame in enumerate(clips.values())])
    api.SetClipManifestAssetPath(Sdf.AssetPath(f"./{manifest}"))
    # Defaults are in a class that the shot inherits; elsewhere they would hide the clips.
    weak = Sdf.Path(f"/_{shot.name}_at_first")
    stage.CreateClassPrim(weak)
    _declare(stage, weak, first)
    _hold(stage, weak, first)
    stage.GetDefaultPrim().GetReferences().AddInternalReference(weak)
    return {name: path.parent / name for name in [*clips, manifest]} | _finish(stage, shot)


def write_still(path: Path, value: Mesh | Strands | Groom, frame: int, fps: float) -> None:
    """Write the shape at a frame, with the prims and attributes of a shot.

    frame  number, which becomes the one time code
    fps    frames per second [1/s]

    Raises BadInput where points are not finite.
    """
    if isinstance(value, Groom):
        strands = Strands(value.points, np.zeros_like(value.points, np.float32), value.offsets, DIAMETER)
        write_shot(path, Shot({frame: strands}, None, value, fps))
    elif isinstance(value, Strands):
        write_shot(path, Shot({frame: value}, None, None, fps))
    else:
        stage = create_stage(path, fps, [frame])
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/shot").GetPrim())
        body = UsdGeom.Mesh.Define(stage, "/shot/body")
        author_body(body, value)
        _sample_body(body, frame, value, value)
        stage.Save()


def _first_frame(shot: Shot) -> Frame:
    if not shot.hair:
        raise BadInput("there are no frames to export", where="hair", right="at least one frame")
    if not Tf.IsValidIdentifier(shot.name):
        right = "letters, digits and underscores, no digit first"
        raise BadInput(f"{shot.name!r} cannot name a prim", where="name", right=right)
    return _load(shot, next(iter(shot.hair)))


def _load(shot: Shot, frame: int) -> Frame:
    hair = shot.hair[frame]
    strands = len(hair.offsets) - 1
    widths = shot.groom.widths if hair.widths is None and shot.groom is not None else hair.widths
    diameters = None
    if shot.hairs is not None:
        diameters = hair.widths_at_points() if widths is None else widths
        widths = drawn_widths(diameters, hair.offsets, shot.hairs / strands)
    if widths is not None:
        hair = replace(hair, widths=widths, diameter=float(widths.max()))  # that extents have room for
    locks = None if shot.states is None else shot.states[frame].leaders(strands)
    if locks is not None and len(locks) != strands:
        raise BadInput("the states are not those of the hair", where="states", right="those of its simulation")
    locks = locks if locks is None or shot.groom is None else shot.groom.ids[locks]
    return Frame(hair, diameters, None if shot.body is None else shot.body[frame], locks)


def _begin_shot(path: Path, shot: Shot, first: Frame) -> Usd.Stage:
    """Create a stage with all constant values, from the first frame."""
    stage = _begin_stage(path, shot, first, list(shot.hair))
    noted = {"cuts": Vt.IntArray(shot.cuts)} if shot.cuts else {}
    noted |= {} if first.body is None else {"body": str(_body(stage).GetPath())}
    stage.GetRootLayer().customLayerData = {"hairpipe": {"version": __version__, **noted}}
    model = Usd.ModelAPI(stage.GetDefaultPrim())
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(shot.name)
    if shot.notes:
        stage.GetDefaultPrim().SetCustomDataByKey(NOTES, dict(shot.notes))
    _author_hair(_hair(stage), shot, first)
    if first.body is not None:
        author_body(_body(stage), first.body)
    if shot.followers is not None:
        _author_followers(stage, shot.followers, shot, first.hair.diameter)
    return stage


def _begin_stage(path: Path, shot: Shot, first: Frame, frames: Sequence[int] = ()) -> Usd.Stage:
    """Create a stage that declares changing attributes without values, as a manifest of clips."""
    stage = create_stage(path, shot.fps, frames)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, f"/{shot.name}").GetPrim())
    _declare(stage, stage.GetDefaultPrim().GetPath(), first)
    return stage


def _declare(stage: Usd.Stage, root: Sdf.Path, first: Frame) -> None:
    """Declare the changing attributes, under a prim."""
    hair = UsdGeom.BasisCurves.Define(stage, root.AppendChild("hair"))
    changing = [hair.CreatePointsAttr, hair.CreateVelocitiesAttr, hair.CreateExtentAttr]
    if first.body is not None:
        body = UsdGeom.Mesh.Define(stage, root.AppendChild("body"))
        changing += [body.CreatePointsAttr, body.CreateNormalsAttr, body.CreateExtentAttr]
        changing += [] if first.body.velocities is None else [body.CreateVelocitiesAttr]
    for declare in changing:
        declare()
    if first.locks is not None:
        _declare_locks(hair)


def _declare_locks(prim: UsdGeom.BasisCurves) -> UsdGeom.Primvar:
    return UsdGeom.PrimvarsAPI(prim).CreatePrimvar("lockId", TYPES.IntArray, TOKENS.uniform)


def _hair(stage: Usd.Stage) -> UsdGeom.BasisCurves:
    return UsdGeom.BasisCurves(stage.GetDefaultPrim().GetChild("hair"))


def _body(stage: Usd.Stage) -> UsdGeom.Mesh:
    return UsdGeom.Mesh(stage.GetDefaultPrim().GetChild("body"))


def _hold(stage: Usd.Stage, root: Sdf.Path, first: Frame) -> None:
    """Author the first frame as defaults, for clients that read only these, at or under a prim."""
    _set_hair(UsdGeom.BasisCurves(stage.OverridePrim(root.AppendChild("hair"))), first)
    if first.body is not None:
        set_body(UsdGeom.Mesh(stage.OverridePrim(root.AppendChild("body"))), first.body)


def _set_hair(prim: UsdGeom.BasisCurves, frame: Frame, time: Usd.TimeCode = ALWAYS) -> None:
    prim.GetPointsAttr().Set(vectors(frame.hair.points), time)
    prim.GetExtentAttr().Set(extent(frame.hair.points, frame.hair.diameter / 2), time)
    if frame.locks is not None:
        _declare_locks(prim).Set(integers(frame.locks), time)


def set_body(prim: UsdGeom.Mesh, mesh: Mesh, time: Usd.TimeCode = ALWAYS) -> None:
    prim.GetPointsAttr().Set(vectors(mesh.points), time)
    prim.GetNormalsAttr().Set(vectors(vertex_normals(mesh)), time)
    prim.GetExtentAttr().Set(extent(mesh.points, 0.0), time)


def _sample(stage: Usd.Stage, number: int, frame: Frame, first: Frame) -> int:
    """Author hair and body at a frame; return the bytes. BadInput for other strands, or points that are not finite."""
    prim = _hair(stage)
    hair = frame.hair
    where = f"hair at frame {number}"
    if not np.array_equal(hair.offsets, first.hair.offsets):
        raise BadInput("the strands are not those of the first frame", where=where, right="the same points per strand")
    for name, array in (("points", hair.points), ("velocities", hair.velocities)):
        owners = np.unique(np.searchsorted(hair.offsets, _not_finite(array), side="right") - 1)
        _refuse(f"strand{'s'[: len(owners) != 1]}", owners, name, where)
    _set_hair(prim, frame, Usd.TimeCode(number))
    prim.GetVelocitiesAttr().Set(vectors(hair.velocities), number)
    size = hair.points.nbytes + hair.velocities.nbytes
    if frame.body is not None and first.body is not None:
        size += _sample_body(_body(stage), number, frame.body, first.body)
    return size


def _sample_body(prim: UsdGeom.Mesh, frame: int, mesh: Mesh, first: Mesh) -> int:
    where = f"body at frame {frame}"
    if not np.array_equal(mesh.triangles, first.triangles) or len(mesh.points) != len(first.points):
        raise BadInput("the triangles are not those of the first frame", where=where, right="the same triangles")
    _refuse("vertices", _not_finite(mesh.points), "points", where)
    if mesh.velocities is not None:
        _refuse("vertices", _not_finite(mesh.velocities), "velocities", where)
        prim.GetVelocitiesAttr().Set(vectors(mesh.velocities), frame)
    set_body(prim, mesh, Usd.TimeCode(frame))
    return 36 * len(mesh.points)


def _not_finite(array: np.ndarray) -> np.ndarray:
    return np.flatnonzero(~np.isfinite(array).all(axis=1))


def _refuse(whose: str, bad: np.ndarray, what: str, where: str) -> None:
    if len(bad):
        listed = ", ".join(map(str, bad[:NAMED])) + (f" and {len(bad) - NAMED} more" if len(bad) > NAMED else "")
        raise BadInput(f"{what} of {whose} {listed} are not finite", where=where, right="finite numbers")


def _author_hair(prim: UsdGeom.BasisCurves, shot: Shot, first: Frame) -> None:
    """Author what is constant: strands, widths, ids, material, marks of simulated ones, rest and roots of a groom."""
    strands, groom = first.hair, shot.groom
    author_curves(prim, np.diff(strands.offsets), BASES[shot.curve])
    prim.CreateWidthsAttr(floats(strands.widths_at_points()))
    prim.SetWidthsInterpolation(TOKENS.vertex)
    if first.diameters is not None:
        primvar(prim, DIAMETERS, TYPES.FloatArray, TOKENS.vertex, floats(first.diameters))
    if groom is None:
        primvar(prim, "hairId", TYPES.IntArray, TOKENS.uniform, integers(np.arange(len(strands.offsets) - 1)))
    elif not np.array_equal(groom.offsets, strands.offsets):
        raise BadInput("the groom does not have the strands of the hair", where="groom", right="what was simulated")
    else:
        primvar(prim, UsdUtils.GetPrefName(), TYPES.Point3fArray, TOKENS.vertex, vectors(groom.points))
        primvar(prim, "hairId", TYPES.IntArray, TOKENS.uniform, integers(groom.ids))
        if groom.root_uv.any():  # a scalp without texture coordinates leaves 0
            uv = pairs(groom.root_uv)
            primvar(prim, UsdUtils.GetPrimaryUVSetName(), TYPES.TexCoord2fArray, TOKENS.uniform, uv)
        primvar(prim, "skinprim", TYPES.IntArray, TOKENS.uniform, integers(groom.root_triangles))
        primvar(prim, "skinprimuv", TYPES.Float2Array, TOKENS.uniform, pairs(groom.root_barycentrics[:, 1:]))
    if shot.simulated is not None:  # the name in Unreal and in Alembic grooms
        primvar(prim, "groom_guide", TYPES.IntArray, TOKENS.uniform, integers(shot.simulated))


def _author_followers(stage: Usd.Stage, followers: Followers, shot: Shot, diameter: float) -> None:
    """Author strands at rest with their guides, inactive until a reader deforms them, and the frames of the guides."""
    groom = followers.groom
    frames = np.swapaxes(followers.keys.root_frames[:, :, :3], 1, 2)  # USD has rows of axes.
    primvar(_hair(stage), "restFrame", TYPES.Matrix3dArray, TOKENS.uniform, Vt.Matrix3dArray.FromNumpy(frames.copy()))
    prim = UsdGeom.BasisCurves.Define(stage, stage.GetDefaultPrim().GetPath().AppendChild("strands"))
    author_curves(prim, np.diff(groom.offsets), BASES[shot.curve])
    prim.CreatePointsAttr(vectors(followers.rest))
    widths = np.full(len(groom.points), diameter) if groom.widths is None else groom.widths
    if shot.hairs is not None:
        widths = drawn_widths(widths, groom.offsets, shot.hairs / len(groom.ids))
    prim.CreateExtentAttr(extent(followers.rest, float(np.max(widths)) / 2))
    prim.CreateWidthsAttr(floats(widths))
    prim.SetWidthsInterpolation(TOKENS.vertex)
    origins = groom.points[groom.offsets[:-1]] - groom.root_frames[:, :, 3]
    primvar(prim, "hairId", TYPES.IntArray, TOKENS.uniform, integers(groom.ids))
    primvar(prim, "skinprim", TYPES.IntArray, TOKENS.uniform, integers(groom.root_triangles))
    primvar(prim, "skinprimuv", TYPES.Float2Array, TOKENS.uniform, pairs(groom.root_barycentrics[:, 1:]))
    offset = np.einsum("sji,sj->si", groom.root_frames[:, :, :3], origins)
    primvar(prim, "rootOffset", TYPES.Float3Array, TOKENS.uniform, vectors(offset))
    elements = followers.places.shape[1]
    kinds = {
        "guideIndex": (TYPES.IntArray, integers(followers.places.ravel())),
        "guideWeight": (TYPES.FloatArray, floats(followers.weights.ravel())),
    }
    for name, (kind, values) in kinds.items():
        primvar(prim, name, kind, TOKENS.uniform, values)
        UsdGeom.PrimvarsAPI(prim).GetPrimvar(name).SetElementSize(elements)
    prim.GetPrim().SetActive(False)


def author_curves(prim: UsdGeom.BasisCurves, counts: np.ndarray, basis: str) -> None:
    """Author pinned cubic curves of so many points each, (S,), with the material of hair."""
    prim.CreateTypeAttr(TOKENS.cubic)
    prim.CreateBasisAttr(basis)
    prim.CreateWrapAttr(TOKENS.pinned)
    prim.CreateCurveVertexCountsAttr(integers(counts))
    _bind(prim, *HAIR)


def author_body(prim: UsdGeom.Mesh, mesh: Mesh) -> None:
    prim.CreateFaceVertexCountsAttr(Vt.IntArray(len(mesh.triangles), 3))
    prim.CreateFaceVertexIndicesAttr(integers(mesh.triangles.ravel()))
    prim.CreateSubdivisionSchemeAttr(TOKENS.none)
    prim.SetNormalsInterpolation(TOKENS.vertex)
    if mesh.uv is not None:
        uv = pairs(mesh.uv.reshape(-1, 2))
        primvar(prim, UsdUtils.GetPrimaryUVSetName(), TYPES.TexCoord2fArray, TOKENS.faceVarying, uv)
    _bind(prim, *SKIN)


def _bind(prim: UsdGeom.Gprim, name: str, colour: Gf.Vec3f, roughness: float, ior: float) -> None:
    """Bind a plain material of its own to the prim, and set its colour, for clients that drop materials of curves.

    The binding is for all purposes: previews ignore one for `full`.
    """
    prim.CreateDisplayColorAttr([colour])
    stage = prim.GetPrim().GetStage()
    root = prim.GetPrim().GetParent().GetPath()
    looks = UsdGeom.Scope.Define(stage, root.AppendChild(UsdUtils.GetMaterialsScopeName()))
    material = UsdShade.Material.Define(stage, looks.GetPath().AppendChild(name))
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", TYPES.Color3f).Set(colour)
    shader.CreateInput("roughness", TYPES.Float).Set(roughness)
    shader.CreateInput("ior", TYPES.Float).Set(ior)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def primvar(prim: UsdGeom.Gprim, name: str, kind: Sdf.ValueTypeName, interpolation: str, value: object) -> None:
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, interpolation).Set(value)


def _array(kind: Any, number: type, values: np.ndarray) -> Any:
    return kind.FromNumpy(np.ascontiguousarray(values, number))


vectors = partial(_array, Vt.Vec3fArray, np.float32)
pairs = partial(_array, Vt.Vec2fArray, np.float32)
floats = partial(_array, Vt.FloatArray, np.float32)
integers = partial(_array, Vt.IntArray, np.int32)
"""Arrays of USD from those of numpy, (n, 3), (n, 2) and (n,), in single precision."""


def extent(points: np.ndarray, padding: float) -> Vt.Vec3fArray:
    """Return lower and upper corner of the box of the points (n, 3) [m], with a padding [m] on all sides."""
    if not len(points):
        return Vt.Vec3fArray([Gf.Vec3f(0), Gf.Vec3f(0)])
    points = np.asarray(points, np.float32)
    return vectors(np.stack([points.min(axis=0) - padding, points.max(axis=0) + padding]))


def _finish(stage: Usd.Stage, shot: Shot) -> dict[str, Path]:
    """Add the level sets, with copies of their files, and save; return these by their names in the stage."""
    folder = Path(stage.GetRootLayer().realPath).parent
    named = dict[str, Path]()
    if shot.levelsets is not None:
        named = {f"{shot.name}.volume/{shot.name}.{frame:04d}.vdb": f.path for frame, f in shot.levelsets.items()}
        _author_volume(stage, shot.levelsets, list(named))
    for name, path in named.items():
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copyfile(path, folder / name)
    stage.Save()
    return {name: folder / name for name in named}


def _author_volume(stage: Usd.Stage, files: Mapping[int, VolumeFile], names: list[str]) -> None:
    """Author a volume of purpose guide under the default prim; BadInput without files."""
    if not files:
        raise BadInput("there are no level sets to export", where="volume", right="at least one frame")
    volume = UsdVol.Volume.Define(stage, stage.GetDefaultPrim().GetPath().AppendChild("levelset"))
    volume.CreatePurposeAttr(TOKENS.guide)
    assets = dict(zip(files, (Sdf.AssetPath(f"./{name}") for name in names), strict=True))
    for grid, (kind, role) in FIELDS.items():
        field = UsdVol.OpenVDBAsset.Define(stage, volume.GetPath().AppendChild(grid))
        field.CreateFieldNameAttr(grid)
        field.CreateFieldDataTypeAttr(kind)
        if role:
            field.CreateFieldClassAttr(role)
        else:
            field.CreateVectorDataRoleHintAttr("Vector")
        volume.CreateFieldRelationship(grid, field.GetPath())
        field.CreateFilePathAttr(next(iter(assets.values())))
        for frame, asset in assets.items():
            field.GetFilePathAttr().Set(asset, frame)
    boxes = {frame: Vt.Vec3fArray([Gf.Vec3f(*corner) for corner in file.box]) for frame, file in files.items()}
    volume.CreateExtentAttr(next(iter(boxes.values())))
    for frame, box in boxes.items():
        volume.GetExtentAttr().Set(box, frame)


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
    frames = [] if shot.hair is None else list(shot.hair)
    stage = create_stage(path, shot.fps, frames)
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
        author_groom(prim, shot, maps, strands, target)
        if piece == "guides":
            prim.CreatePurposeAttr(TOKENS.guide)
        pieces.append((prim, shot.rows(strands)))
    for frame in frames:
        hair = shot.at(frame)
        widths = shot.widths(hair)
        for prim, rows in pieces:
            sample_groom(prim, hair, rows, widths, frame, target)
    if shot.scalp is not None:
        mesh = replace(shot.scalp.mesh, points=target.placed(shot.scalp.mesh.points), velocities=None)
        prim = UsdGeom.Mesh.Define(stage, "/groom/scalp")
        author_body(prim, mesh)
        set_body(prim, mesh)
        for rest in target.rest:
            primvar(prim, rest, TYPES.Point3fArray, TOKENS.vertex, vectors(mesh.points))
    stage.Save()


def author_groom(
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


def sample_groom(
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
