"""Stages: creation, opening with clear messages, conversion to metres with Y up, attributes as arrays.

OpenUSD composes a stage without the files and prims that it names and that do not exist: these are refused or reported.
The files are checked before: opening a pipe or a device may never return.
"""

import math
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pxr import Ar, Pcp, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdVol

from hairpipe.apart import extend_time
from hairpipe.errors import BadInput
from hairpipe.formats.registry import USD
from hairpipe.plain_file import Absent, checked_size, special_kind

NOTES = "hairpipe"
"""Name of our metadata of a layer, and of the root prim of a shot."""
TEMPLATE = 100_000  # maximum number of files of a template


def list_files(path: Path) -> list[Path]:
    """Return the files that a stage is composed of, that of the path first, and those that do not exist."""
    return [Path(file) for file in find_layers(path)[1]]


def find_layers(path: Path) -> tuple[list[Sdf.Layer], dict[str, int]]:
    """Open all layers of a stage, and find the files of its value clips.

    Returns layers, which OpenUSD does not read again while they are referred to, and the sizes of all files by path
    [bytes], 0 where one is missing. Raises BadInput if one of them is not a regular file.
    """
    found = list[Sdf.Layer]()
    sizes = dict[str, int]()
    pending = [str(path)]
    while pending:
        file = pending.pop()
        if file in sizes:
            continue
        sizes[file] = _plain_size(file, path)
        try:
            layer = Sdf.Layer.FindOrOpen(file)
        except (Tf.ErrorException, UnicodeDecodeError):  # composition reports it
            continue
        if layer is not None:
            found.append(layer)
            pending += [resolve(layer, name) for name in layer.GetCompositionAssetDependencies() if name]
            prims = [spec for spec in specs_in(layer) if isinstance(spec, Sdf.PrimSpec)]
            clips = [resolve(layer, name) for prim in prims for name in clip_names(prim) if name]
            sizes |= {clip: _plain_size(clip, path) for clip in clips if clip not in sizes}
    return found, sizes


def specs_in(layer: Sdf.Layer) -> Iterator[Sdf.Spec]:
    """Yield all specs of a layer."""
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    return filter(None, map(layer.GetObjectAtPath, paths))


def clip_names(spec: Sdf.PrimSpec) -> Iterator[str]:
    """Name the files of the value clips of a prim."""
    for clips in (spec.GetInfo("clips") or {}).values():
        if not isinstance(clips, dict):
            continue
        named = [*clips.get("assetPaths", ()), clips.get("manifestAssetPath")]
        yield from (asset.path for asset in named if isinstance(asset, Sdf.AssetPath))
        template = clips.get("templateAssetPath")
        span = [clips.get("templateStartTime"), clips.get("templateEndTime"), clips.get("templateStride", 1.0)]
        if isinstance(template, str) and all(isinstance(n, float) and math.isfinite(n) for n in span) and span[2] > 0:
            yield from expand(template, *span)


def expand(template: str, start: float, end: float, stride: float) -> Iterator[str]:
    """List the files of a template such as hair.####.usdc; USD omits missing ones without a warning."""
    hashes = re.search(r"(#+)(?:\.(#+))?", template)
    if hashes:
        whole = len(hashes[1])
        part = len(hashes[2] or "")
        width = whole + part + 1 if part else whole
        for step in range(int(min((end - start) / stride + 1e-6, TEMPLATE)) + 1):
            yield f"{template[: hashes.start()]}{start + step * stride:0{width}.{part}f}{template[hashes.end() :]}"


def resolve(layer: Sdf.Layer, name: str) -> str:
    """Return the path of a file by its name in a layer, whether it exists or not; for one in a package, the package."""
    place = layer.ComputeAbsolutePath(name)
    return (Ar.GetResolver().Resolve(place).GetPathString() or place).partition("[")[0]


def _plain_size(file: str, stage: Path) -> int:
    try:
        found = Path(file).stat()
    except (OSError, ValueError):
        return 0
    if kind := special_kind(found):
        raise BadInput(f"refers to {Path(file).name}, which is {kind}", where=stage, right="layers that are files")
    return found.st_size


DROPPED = (Pcp.ErrorInvalidAssetPath, Pcp.ErrorInvalidSublayerPath, Pcp.ErrorUnresolvedPrimPath)
"""Errors of composition by which a reference, payload or sublayer is left out."""
FORMS = (
    r"Could not open asset @(?P<name>.*?)@ for (?P<kind>\w+) introduced by @(?P<file>.*?)@<(?P<prim>.*?)>",
    r"Could not load (?P<kind>sublayer) @(?P<name>.*?)@ of layer @(?P<file>.*?)@",
    r"Unresolved (?P<kind>\w+) prim path @(?P<name>.*?)@<(?P<target>.*?)> introduced by @(?P<file>.*?)@<(?P<prim>.*?)>",
)
"""Messages of OpenUSD, which has no other account of these errors."""
RIGHT = 'all files of the stage, or absent = "warn" to read the rest'
DOUBLES = ("metersPerUnit", "timeCodesPerSecond", "framesPerSecond", "startTimeCode", "endTimeCode")
"""Numbers of a layer, which are set as doubles, in memory: other programs write floats, at which OpenUSD fails."""
NAMED = 5  # number of shapes in a message
LINE = 160  # maximum length of a message of OpenUSD
GUIDE = UsdGeom.Tokens.guide
RENDERED = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)  # purposes
Z_UP_TO_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
WHOLE = Usd.TraverseInstanceProxies()


Gap = tuple[Sdf.Path, str, str]
"""An absent file or prim: path of the prim of the stage that would have it, kind and name, referring layer and prim."""


def check_whole(stage: Usd.Stage, prim: str | None, absent: Absent) -> None:
    """Raise BadInput for an absent reference, payload, sublayer or value clip, or warn of all.

    Inactive prims and variants that are not selected do not count. Those that a prim does not need are warned of.
    """
    gaps = list(dict.fromkeys((*_left_out(stage), *_absent_clips(stage))))
    needed = _needed_by(stage, prim)
    for path, what, where in gaps:
        related = needed is None or any(path.HasPrefix(p) or p.HasPrefix(path) for p in needed)
        if absent == "refuse" and related:
            more = f", and {len(gaps) - 1} more" if len(gaps) > 1 else ""
            raise BadInput(f"{what}{more}", where=where, right=RIGHT)
        warnings.warn(f"{where}: {what}, and is left out", stacklevel=2)


def _left_out(stage: Usd.Stage) -> Iterator[Gap]:
    """Yield the references, payloads and sublayers that composition has left out."""
    for error in stage.GetCompositionErrors():
        prim = stage.GetPrimAtPath(error.rootSite.path)
        if isinstance(error, DROPPED) and not (prim and not prim.IsActive()):
            found = next((match for form in FORMS if (match := re.match(form, str(error)))), None)
            what, where = (str(error), stage_path(stage)) if found is None else _described(**found.groupdict())
            yield error.rootSite.path, what, where


def _described(name: str, kind: str, file: str, prim: str = "/", target: str = "") -> tuple[str, str]:
    """Return what is absent, and where it is named, from the parts of a message of OpenUSD."""
    where = f"{Path(file)} {prim}" if prim != "/" else str(Path(file))
    if target:
        what = "a defaultPrim" if target == "defaultPrim" else f"the prim {target}"
        return f"{name} does not have {what} of a {kind}", where
    state = "cannot be read" if Path(name).is_absolute() and Path(name).exists() else "does not exist"
    return f"the {kind} {name} {state}", where


def _absent_clips(stage: Usd.Stage) -> Iterator[Gap]:
    """Yield the value clips that do not exist, which USD does not report."""
    for prim in stage.Traverse(WHOLE):
        for spec in prim.GetPrimStack() if prim.HasAuthoredMetadata("clips") else ():
            lost = [name for name in clip_names(spec) if not Path(resolve(spec.layer, name)).exists()]
            if lost:
                more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
                what = f"the value clip {lost[0]}{more} {'do' if more else 'does'} not exist"
                yield prim.GetPath(), what, f"{spec.layer.realPath} {spec.path}"


def _needed_by(stage: Usd.Stage, prim: str | None) -> set[Sdf.Path] | None:
    """Return the paths of a prim, its skeletons and their animations; None for all of the stage."""
    if prim is None or set(prim) & set("*?[") or not Sdf.Path.IsValidPathString(prim):
        return None
    found = set[Sdf.Path]()
    pending = [Sdf.Path(prim)]
    while pending:
        path = pending.pop()
        if path in found:
            continue
        found.add(path)
        at = stage.GetPrimAtPath(path)
        below = Usd.PrimRange(at, WHOLE) if at else ()
        above = (stage.GetPrimAtPath(one) for one in path.GetParentPath().GetPrefixes())
        for one in (*(a for a in above if a), *below):
            bound = one.GetPropertiesInNamespace("skel")
            pending += [target for r in bound if isinstance(r, Usd.Relationship) for target in r.GetForwardedTargets()]
    return found


def create_stage(path: Path, fps: float, frames: Sequence[int] = ()) -> Usd.Stage:
    """Create a stage in metres with Y up, with frames as time codes, at `fps` frames per second [1/s]."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    if frames:
        stage.SetStartTimeCode(frames[0])
        stage.SetEndTimeCode(frames[-1])
    return stage


def open_stage(path: Path) -> Usd.Stage:
    """Open the file as a stage; BadInput if it, or one of its layers, is not a readable file of USD."""
    right = "a file that ends in " + ", ".join(USD.suffixes)
    if path.suffix.lower() not in USD.suffixes:
        raise BadInput("not named like a USD file", where=path, right=right)
    checked_size(path, right)
    with usd_faults(path):
        layers, sizes = find_layers(path)
        extend_time(sum(sizes.values()))
        for layer in layers:
            root = layer.pseudoRoot
            for name in DOUBLES if layer.permissionToEdit else ():
                if root.HasInfo(name):
                    root.SetInfo(name, float(root.GetInfo(name)))
        stage = Usd.Stage.Open(str(path))
        del layers  # which were kept open until the stage has them
    return stage


def open_whole(path: Path, prim: str | None, absent: Absent) -> Usd.Stage:
    """Open the file as a stage of which a node reads a prim, None for all.

    Raises BadInput as `open_stage` and `check_whole` do, and for rates that are not positive.
    """
    stage = open_stage(path)
    _check_rates(stage)
    check_whole(stage, prim, absent)
    return stage


def _check_rates(stage: Usd.Stage) -> None:
    """Refuse layers whose time codes have no duration; warn of rates that differ, by which USD scales time codes."""
    rate = stage.GetTimeCodesPerSecond()
    root = stage.GetRootLayer()
    for layer in stage.GetUsedLayers(includeClipLayers=False):
        own = layer.timeCodesPerSecond
        if not (np.isfinite(own) and own > 0.0):
            right = "a positive number, such as 24"
            raise BadInput(f"timeCodesPerSecond is {own:g}", where=layer.realPath or stage_path(stage), right=right)
        if layer != root and own != rate and not layer.anonymous and layer.ListAllTimeSamples():
            stated = "" if root.HasTimeCodesPerSecond() else ", as it states none"
            what = f"{layer.realPath} has {own:g} time codes a second, {root.GetDisplayName()} {rate:g}{stated}"
            kept = f"timeCodesPerSecond = {own:g} in {root.GetDisplayName()} keeps them"
            warnings.warn(f"{what}: its time codes are multiplied by {rate / own:.5g} ({kept})", stacklevel=3)


def go_to(stage: Usd.Stage, time: float | None) -> None:
    """Set the time of a stage, see `time_of`; by default that of `common_time`."""
    stage.GetSessionLayer().startTimeCode = (common_time(stage) or 0.0) if time is None else time


def time_of(prim: Usd.Prim) -> Usd.TimeCode:
    """Return the time at which a stage is read: its start."""
    return Usd.TimeCode(prim.GetStage().GetStartTimeCode())


def common_time(stage: Usd.Stage) -> float | None:
    """Return the first time code at which all meshes and curves have samples; None without samples."""
    prims = [p for p in stage.Traverse(WHOLE) if p.IsA(UsdGeom.PointBased)]
    firsts = [times[0] for p in prims for times in _samples(p) if times]
    return max(firsts, default=None)


def read_time(prims: Sequence[Usd.Prim], time: float | None) -> float | None:
    """Return the time code at which shapes are read, None for constant ones; warn of a default time code."""
    if not any(len(times) > 1 for prim in prims for times in _samples(prim)):
        return None
    stage = prims[0].GetStage()
    if time is None:
        why = "the first at which all meshes and curves have samples"
        message = f"{stage_path(stage)} is read at time code {stage.GetStartTimeCode():g}, {why}"
        warnings.warn(f"{message}; time_code selects another", stacklevel=2)
    return stage.GetStartTimeCode()


def _samples(prim: Usd.Prim) -> Iterator[list[float]]:
    """Yield the time codes of the points of a shape, and of each transform above it."""
    yield UsdGeom.PointBased(prim).GetPointsAttr().GetTimeSamples()
    yield from (space.GetTimeSamples() for space in spaces_of(prim))


def transform_codes(prim: Usd.Prim) -> Iterator[list[float]]:
    """Yield the time codes of each operation of the transforms that move a prim."""
    for space in spaces_of(prim):
        yield from (operation.GetTimeSamples() for operation in space.GetOrderedXformOps())


def spaces_of(prim: Usd.Prim) -> Iterator[UsdGeom.Xformable]:
    """Yield the prims whose transforms move a prim: it and its parents."""
    while prim.IsA(UsdGeom.Xformable):
        yield UsdGeom.Xformable(prim)
        prim = prim.GetParent()


@contextmanager
def usd_faults(path: Path) -> Iterator[None]:
    """Raise errors of OpenUSD in this block as BadInput."""
    try:
        yield
    except Tf.ErrorException as error:
        what = f"not a readable USD file: {message_of(error)}"
        raise BadInput(what, where=path, right="a file OpenUSD can open") from None
    except UnicodeDecodeError:
        raise BadInput("a name or text in the file is not UTF-8", where=path, right="a USD file in UTF-8") from None


def message_of(error: Tf.ErrorException) -> str:
    """Return the message of OpenUSD on one line, with line and column first if it has them."""
    try:
        line = error.args[0].commentary.splitlines()[0]
    except UnicodeDecodeError:
        return "text in it is not UTF-8"
    return shortened(re.sub(r"^.*:(\d+):(\d+): ", r"line \1, column \2: ", line))


def shortened(text: str) -> str:
    """Return a message of OpenUSD on one line of limited length."""
    line = " ".join(text.split())
    return line if len(line) <= LINE else line[:LINE] + "..."


def to_metres(stage: Usd.Stage) -> np.ndarray:
    """Return the matrix from a world to metres with Y up, column vectors, (4, 4) float64; BadInput without a unit."""
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    if not (np.isfinite(scale) and scale > 0):
        raise BadInput(f"metersPerUnit is {scale:g}", where=stage_path(stage), right="a positive number")
    matrix = np.eye(4)
    matrix[:3, :3] = scale * (Z_UP_TO_Y_UP if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z else np.eye(3))
    return matrix


def place(prim: Usd.Prim) -> np.ndarray:
    """Return the matrix from the prim to metres with Y up at the time of the stage, column vectors, (4, 4) float64."""
    world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time_of(prim))
    matrix = to_metres(prim.GetStage()) @ columns(world)
    if not np.isfinite(matrix).all():
        raise BadInput("the transform is not finite", where=location(prim), right="finite numbers")
    return matrix


def columns(matrix: object) -> np.ndarray:
    """Return a Gf.Matrix4d, which acts on row vectors, as a matrix that acts on column vectors, (4, 4) float64."""
    return np.array(matrix, dtype=np.float64).T


def move(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) moved by an affine matrix (4, 4), float64."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def shown(
    stage: Usd.Stage, prim: str | None, *schemas: type, guides: Literal["no", "only", "also"] = "no"
) -> list[Usd.Prim]:
    """Return the visible prims of some schemas with purpose default or render, in the order of the stage.

    prim    path, or a pattern of paths such as */hair*; only prims at or under it
    guides  whether prims of purpose guide are used: only where there are no others, or also

    Raises BadInput if there is no such prim, or none of the schemas.
    """
    pattern = prim if prim is not None and set(prim) & set("*?[") else None
    root = stage.GetPseudoRoot() if prim in (None, pattern) else _prim_at(stage, prim)
    whole = Usd.PrimRange(root, WHOLE)
    under = [p for p in whole if not pattern or any(fnmatchcase(str(q), pattern) for q in p.GetPath().GetPrefixes())]
    states = {p: _state(p, schemas) for p in under if _is_rival(p, schemas)}
    drawn = [f"purpose {token}" for token in (*RENDERED, *([GUIDE] if guides == "also" else []))]
    found = [p for p, state in states.items() if state in drawn]
    if guides == "only" and not found:
        found = [p for p, state in states.items() if state == f"purpose {GUIDE}"]
    if not found:
        place = "" if prim is None else f" at or under {prim}"
        named = " or ".join(schema.__name__ for schema in schemas)
        curves = [p for p in Usd.PrimRange(root, WHOLE) if p.IsA(UsdGeom.Curves)]
        others = sorted({p.GetTypeName() for p in curves if not _is_one(p, schemas)})
        instead = f", but {' and '.join(others)}, which are not read" if others else ""
        right = f"a prim of the type {named} and the purpose {' or '.join(RENDERED)}"
        raise BadInput(f"no visible {named}{place}{instead}", where=stage_path(stage), right=right)
    if left := [p for p in states if p not in found]:
        named = ", ".join(f"{p.GetPath()} ({states[p]})" for p in left[:NAMED])
        more = f" and {len(left) - NAMED} more" if len(left) > NAMED else ""
        warnings.warn(f"{stage_path(stage)}: shapes that are not read: {named}{more}", stacklevel=2)
    return found


def _is_one(prim: Usd.Prim, schemas: Sequence[type]) -> bool:
    return any(prim.IsA(schema) for schema in schemas)


def _is_rival(prim: Usd.Prim, schemas: Sequence[type]) -> bool:
    """Return whether a prim is a shape of the kind of the schemas: curves, or surfaces."""
    if issubclass(schemas[0], UsdGeom.Curves):
        return prim.IsA(UsdGeom.Curves)
    is_surface = prim.IsA(UsdGeom.Gprim) and prim.GetTypeName() not in ("Points", "Volume")
    return is_surface and not prim.IsA(UsdGeom.Curves)


def _state(prim: Usd.Prim, schemas: Sequence[type]) -> str:
    """Return the purpose of a visible shape of the schemas, or why another one is not read."""
    image = UsdGeom.Imageable(prim)
    if not _is_one(prim, schemas):
        return f"a {prim.GetTypeName()}"
    is_visible = image.ComputeVisibility(time_of(prim)) != UsdGeom.Tokens.invisible
    return f"purpose {image.ComputePurpose()}" if is_visible else "invisible"


def _prim_at(stage: Usd.Stage, path: str) -> Usd.Prim:
    found = stage.GetPrimAtPath(path) if path.startswith("/") else None
    if not found:
        children = ", ".join(str(p.GetPath()) for p in stage.GetPseudoRoot().GetChildren())
        raise BadInput(f"no prim {path}", where=stage_path(stage), right=f"a path under {children or 'a root prim'}")
    return found


def numbers(attribute: Usd.Attribute, columns: int = 1, kind: type = np.float64) -> np.ndarray:
    """Return an array attribute at the time of the stage, as of `checked`."""
    return checked(attribute.Get(time_of(attribute.GetPrim())), attribute, columns, kind)


def checked(value: object, attribute: Usd.Attribute, columns: int = 1, kind: type = np.float64) -> np.ndarray:
    """Return a value as `shaped` does, of a kind of numbers; BadInput also for numbers that are not finite."""
    array = shaped(value, attribute, columns)
    if not np.isfinite(array).all():
        row = int(np.argmin(np.isfinite(array.reshape(len(array), -1)).all(axis=1)))
        where = f"{location(attribute.GetPrim())}.{attribute.GetName()}"
        raise BadInput(f"element {row} is not finite", where=where, right="finite numbers")
    return array.astype(kind)


def shaped(value: object, attribute: Usd.Attribute, columns: int = 1) -> np.ndarray:
    """Return a value of an attribute as an array (n,) or (n, columns) float64; BadInput for another type.

    No value is an empty array.
    """
    shape = (0,) if columns == 1 else (0, columns)
    array = np.empty(shape) if value is None else np.array(value)
    where = f"{location(attribute.GetPrim())}.{attribute.GetName()}"
    if array.dtype.kind not in "iuf" or array.shape[1:] != shape[1:] or array.ndim != len(shape):
        right = "an array of numbers" if columns == 1 else f"an array of {columns} numbers each"
        raise BadInput(f"holds a {type(value).__name__}", where=where, right=right)
    return array.astype(np.float64)


def location(prim: Usd.Prim) -> str:
    """Return file and prim path, for messages."""
    return f"{stage_path(prim.GetStage())} {prim.GetPath()}"


def stage_path(stage: Usd.Stage) -> str:
    return stage.GetRootLayer().realPath


INPUTS = ("diffuseColor", "roughness", "ior")
"""Inputs of a UsdPreviewSurface that a shader for hair has, too."""


def find_drawn(path: Path) -> dict[str, Any]:
    """Find how the curves and volumes of a stage are drawn; BadInput where the file cannot be read.

    prims   of each by its name: type, purpose, and name and inputs of its material
    frames  first and last time code, and time codes per second; None without time codes
    """
    with usd_faults(path):
        stage = open_stage(path)
        shapes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Curves) or p.IsA(UsdVol.Volume)]
        times = [stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()]
        frames = times if stage.HasAuthoredTimeCodeRange() else None
        return {"prims": {shape.GetName(): look_of(shape) for shape in shapes}, "frames": frames}


def look_of(prim: Usd.Prim) -> dict[str, Any]:
    look: dict[str, Any] = {"type": str(prim.GetTypeName()), "purpose": str(UsdGeom.Imageable(prim).ComputePurpose())}
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    if material:
        look["material"] = material.GetPrim().GetName()
        shader, *_ = material.ComputeSurfaceSource()
        given = {name: shader.GetInput(name) for name in INPUTS} if shader else {}
        values = {name: found.Get() for name, found in given.items() if found}
        look["look"] = {
            n: list(map(float, v)) if n == INPUTS[0] else float(v) for n, v in values.items() if v is not None
        }
    return look
