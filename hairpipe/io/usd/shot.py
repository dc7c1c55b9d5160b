"""A shot: simulated hair and the body under it, as one file or as one value clip per frame.

The schema is the common subset of renderers: Catmull-Rom curves, by default, interpolate the simulated points, `pinned`
keeps the root on the skin in every client, and all clients read widths on vertices. Points are relative to the origin
of the world, in single precision: a kilometre away their errors are up to 0.03 mm.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from pxr import Kind, Sdf, Tf, Usd, UsdGeom, Vt

from hairpipe import __version__
from hairpipe.data import Groom, Mesh, Strands
from hairpipe.data.drawn_widths import drawn_widths
from hairpipe.data.hair import HairState
from hairpipe.errors import BadInput
from hairpipe.io.usd.samples import declare_locks, hold_body, hold_hair, locks_of, sample_body, sample_hair
from hairpipe.io.usd.stage import create_stage
from hairpipe.io.usd.statics import BASES, author_body, author_hair
from hairpipe.io.usd.volume import VolumeFile, write_volume

PENDING = 1 << 24  # bytes of samples in memory before they are saved, so that memory does not grow with the shot


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


@dataclass(frozen=True)
class Frame:
    """Hair and body at one frame.

    hair       with the widths of a picture
    diameters  of the hair at its points where widths are others, (p,) [m]
    locks      ids of the guides of strands, (S,), see `locks_of`
    """

    hair: Strands
    diameters: np.ndarray | None
    body: Mesh | None
    locks: np.ndarray | None


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
    _refer(Usd.ClipsAPI(stage.GetDefaultPrim()), clips, manifest)
    _hold_weakly(stage, shot, first)
    return {name: path.parent / name for name in [*clips, manifest]} | _finish(stage, shot)


def _refer(api: Usd.ClipsAPI, clips: Mapping[str, int], manifest: str) -> None:
    """List the clips without a template, since a run may skip frames; the time of a clip is that of the stage."""
    api.SetClipPrimPath(str(api.GetPath()))
    api.SetClipAssetPaths(Sdf.AssetPathArray([Sdf.AssetPath(f"./{name}") for name in clips]))
    api.SetClipActive([(frame, index) for index, frame in enumerate(clips.values())])
    api.SetClipManifestAssetPath(Sdf.AssetPath(f"./{manifest}"))


def _finish(stage: Usd.Stage, shot: Shot) -> dict[str, Path]:
    """Add the level sets and save; returns their files."""
    files = {} if shot.levelsets is None else write_volume(stage, shot.name, shot.levelsets)
    stage.Save()
    return files


def _hold(stage: Usd.Stage, root: Sdf.Path, first: Frame) -> None:
    """Author the first frame as defaults, at or under a prim."""
    hold_hair(UsdGeom.BasisCurves(stage.OverridePrim(root.AppendChild("hair"))), first.hair, first.locks)
    if first.body is not None:
        hold_body(UsdGeom.Mesh(stage.OverridePrim(root.AppendChild("body"))), first.body)


def _hold_weakly(stage: Usd.Stage, shot: Shot, first: Frame) -> None:
    """Author the first frame as defaults in a class that the shot inherits; elsewhere they would hide the clips."""
    path = Sdf.Path(f"/_{shot.name}_at_first")
    stage.CreateClassPrim(path)
    _declare(stage, path, first)
    _hold(stage, path, first)
    stage.GetDefaultPrim().GetReferences().AddInternalReference(path)


def _first_frame(shot: Shot) -> Frame:
    if not shot.hair:
        raise BadInput("there are no frames to export", where="hair", right="at least one frame")
    if not Tf.IsValidIdentifier(shot.name):
        right = "letters, digits and underscores, no digit first"
        raise BadInput(f"{shot.name!r} cannot name a prim", where="name", right=right)
    return _load(shot, next(iter(shot.hair)))


def _load(shot: Shot, frame: int) -> Frame:
    hair = shot.hair[frame]
    widths = shot.groom.widths if hair.widths is None and shot.groom is not None else hair.widths
    diameters = None
    if shot.hairs is not None:
        diameters = hair.widths_at_points() if widths is None else widths
        widths = drawn_widths(diameters, hair.offsets, shot.hairs / (len(hair.offsets) - 1))
    if widths is not None:
        hair = replace(hair, widths=widths, diameter=float(widths.max()))  # that extents have room for
    locks = None if shot.states is None else locks_of(shot.states[frame], shot.groom, len(hair.offsets) - 1)
    return Frame(hair, diameters, None if shot.body is None else shot.body[frame], locks)


def _begin_shot(path: Path, shot: Shot, first: Frame) -> Usd.Stage:
    """Create a stage with all constant values, from the first frame."""
    stage = _begin_stage(path, shot, first)
    frames = list(shot.hair)
    stage.SetStartTimeCode(frames[0])
    stage.SetEndTimeCode(frames[-1])
    noted = {"cuts": Vt.IntArray(shot.cuts)} if shot.cuts else {}
    noted |= {} if first.body is None else {"body": str(_body(stage).GetPath())}
    stage.GetRootLayer().customLayerData = {"hairpipe": {"version": __version__, **noted}}
    model = Usd.ModelAPI(stage.GetDefaultPrim())
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(shot.name)
    author_hair(_hair(stage), first.hair, first.diameters, shot.groom, shot.simulated, BASES[shot.curve])
    if first.body is not None:
        author_body(_body(stage), first.body)
    return stage


def _begin_stage(path: Path, shot: Shot, first: Frame) -> Usd.Stage:
    """Create a stage that declares changing attributes without values, as a manifest of clips."""
    stage = create_stage(path, shot.fps)
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
        declare_locks(hair)


def _hair(stage: Usd.Stage) -> UsdGeom.BasisCurves:
    return UsdGeom.BasisCurves(stage.GetDefaultPrim().GetChild("hair"))


def _body(stage: Usd.Stage) -> UsdGeom.Mesh:
    return UsdGeom.Mesh(stage.GetDefaultPrim().GetChild("body"))


def _sample(stage: Usd.Stage, number: int, frame: Frame, first: Frame) -> int:
    """Author the samples of a frame; returns the bytes."""
    size = sample_hair(_hair(stage), number, frame.hair, first.hair, frame.locks)
    if frame.body is not None and first.body is not None:
        size += sample_body(_body(stage), number, frame.body, first.body)
    return size
