"""Rules for files that a stage refers to, OpenVDB among them, and for value clips; OpenUSD does not validate these."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Tf, Usd, UsdVol

from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.scene import Fault, fault_of
from hairpipe.formats.usd.stage import clip_names, message_of, specs_in
from hairpipe.plain_file import special

ABSOLUTE = re.compile(r"^(/|\\\\|[A-Za-z]:[/\\]|file:)")
CLASSES = {"levelSet": "level set", "fogVolume": "fog volume", "staggered": "staggered"}
"""Names of grid classes in USD, and in OpenVDB."""


@dataclass(frozen=True)
class Asset:
    """A file that a layer names.

    layer  layer that names the file
    path   of the prim or attribute
    name   as in the layer
    time   code of the sample, or None
    data   whether the file contains frames, which belong to the layer, and is not a shared asset
    """

    layer: Sdf.Layer
    path: str
    name: str
    time: float | None = None
    data: bool = False

    @property
    def file(self) -> str:
        """Return the path of the file, empty for a missing one."""
        return Ar.GetResolver().Resolve(self.layer.ComputeAbsolutePath(self.name)).GetPathString()


def find_assets(stage: Usd.Stage) -> list[Asset]:
    """Return every file that the layers of a stage name, also missing ones."""
    return [asset for layer in stage.GetUsedLayers() if not layer.anonymous for asset in _named_by(layer)]


def _named_by(layer: Sdf.Layer) -> Iterator[Asset]:
    yield from (Asset(layer, "/", name) for name in layer.subLayerPaths)
    for spec in specs_in(layer):
        path = str(spec.path)
        if isinstance(spec, Sdf.PrimSpec):
            arcs = (arc for list_ in (spec.referenceList, spec.payloadList) for arc in list_.GetAddedOrExplicitItems())
            yield from (Asset(layer, path, arc.assetPath) for arc in arcs if arc.assetPath)
            yield from (Asset(layer, path, name, data=True) for name in clip_names(spec))
        elif isinstance(spec, Sdf.AttributeSpec) and spec.typeName.scalarType == Sdf.ValueTypeNames.Asset:
            yield from _values(layer, spec)


def _values(layer: Sdf.Layer, spec: Sdf.AttributeSpec) -> Iterator[Asset]:
    times = layer.ListTimeSamplesForPath(spec.path)
    values = [(None, spec.default), *((time, layer.QueryTimeSample(spec.path, time)) for time in times)]
    for time, value in values:
        for asset in value if isinstance(value, Sdf.AssetPathArray) else [value]:
            if isinstance(asset, Sdf.AssetPath) and asset.path and "<UDIM>" not in asset.path:
                yield Asset(layer, str(spec.path), asset.path, time, data=time is not None)


def missing_file(asset: Asset) -> Iterator[Fault]:
    """Find missing files; MissingReferenceValidator of OpenUSD names no attribute or time, and hangs at a pipe."""
    if not asset.file:
        yield Fault(asset.path, f"names {asset.name}, which does not exist", asset.time)
    elif kind := special(Path(asset.file.partition("[")[0])):
        yield Fault(asset.path, f"names {asset.name}, which is {kind}", asset.time)


def broken_layer(asset: Asset) -> Iterator[Fault]:
    """Find existing layers that cannot be opened."""
    plain = asset.file and not special(Path(asset.file.partition("[")[0]))
    if plain and Sdf.FileFormat.FindByExtension(asset.file):
        try:
            Sdf.Layer.FindOrOpen(asset.file)
        except Tf.ErrorException as error:
            yield Fault(asset.path, f"names {asset.name}, which does not open: {message_of(error)}", asset.time)


def absolute_path(asset: Asset) -> Iterator[Fault]:
    """Find files that do not exist on another machine."""
    if ABSOLUTE.match(asset.name):
        yield Fault(asset.path, f"names {asset.name}; use a path relative to the layer", asset.time)
    elif "\\" in asset.name:
        yield Fault(asset.path, f"names {asset.name}, found on one system alone; write / between folders", asset.time)
    elif asset.data and asset.name.startswith("../"):
        yield Fault(asset.path, f"names {asset.name}, which is not in the folder of the layer or below", asset.time)


Inspect = Callable[[Path], Sequence[Any]]
"""Lists the grids of an OpenVDB file, with `name` and `grid_class`; raises BadInput for another file."""


def openvdb_grid(prim: Usd.Prim, inspect: Inspect | None) -> Iterator[Fault]:
    """Find OpenVDB files that cannot be opened, or do not have the grid of the field's name and class."""
    if inspect is None or not prim.IsA(UsdVol.OpenVDBAsset):
        return
    field = UsdVol.OpenVDBAsset(prim)
    attribute = field.GetFilePathAttr()
    for time in attribute.GetTimeSamples() or [None]:
        asset = attribute.Get(Usd.TimeCode.Default() if time is None else time)
        if asset and asset.resolvedPath:
            message = _mismatch(Path(asset.resolvedPath), field, inspect)
            if message:
                yield fault_of(attribute, message, time)


def _mismatch(path: Path, field: UsdVol.OpenVDBAsset, inspect: Inspect) -> str:
    try:
        grids = {grid.name: grid.grid_class for grid in inspect(path)}
    except BadInput as fault:
        return f"{path.name} does not open: {fault.what}"
    name = field.GetFieldNameAttr().Get()
    kind = field.GetFieldClassAttr().Get()
    if name not in grids:
        return f"{path.name} has no grid {name!r}, but {', '.join(map(repr, sorted(grids))) or 'none at all'}"
    if kind in CLASSES and grids[name] != CLASSES[kind]:
        return f"grid {name!r} of {path.name} is a {grids[name] or 'grid without class'}, no {CLASSES[kind]}"
    return ""


METRICS = ("timeCodesPerSecond", "framesPerSecond", "metersPerUnit", "upAxis")
"""Metadata of layers that clips do not convert."""


Clips = list[tuple[str, Sdf.Layer | None]]


def _clip_sets(prim: Usd.Prim) -> Iterator[tuple[str, str, Sdf.Layer | None, Clips]]:
    """Yield the sets of value clips: name, path of the prim in the clips, manifest, and files with their layers."""
    api = Usd.ClipsAPI(prim)
    for name in prim.GetMetadata("clips") or {}:
        clips = [(asset.path, _open(prim, asset)) for asset in api.ComputeClipAssetPaths(name)]
        yield name, api.GetClipPrimPath(name), _open(prim, api.GetClipManifestAssetPath(name)), clips


def _open(prim: Usd.Prim, asset: Sdf.AssetPath | None) -> Sdf.Layer | None:
    if not asset or not asset.path:
        return None
    resolved = asset.resolvedPath or prim.GetStage().GetRootLayer().ComputeAbsolutePath(asset.path)
    return Sdf.Layer.FindOrOpen(resolved)


def clip_manifest(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a manifest: all of them are opened for the first value."""
    for name, clips in (prim.GetMetadata("clips") or {}).items():
        if not clips.get("manifestAssetPath"):
            yield fault_of(prim, f"clip set {name} has no manifestAssetPath")


def clip_values(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without an attribute of the manifest; USD interpolates it from their neighbours."""
    for _, path, manifest, clips in _clip_sets(prim):
        promised = _attributes(manifest, path or "/") if manifest else []
        for file, clip in clips:
            lacking = [p for p in promised if not clip.ListTimeSamplesForPath(p)] if clip else []
            if lacking:
                yield fault_of(prim, f"{file} has no samples of {lacking[0]}; {len(lacking)} such")


def clip_undeclared(prim: Usd.Prim) -> Iterator[Fault]:
    """Find attributes of clips that the manifest does not declare: they are never read."""
    for name, path, manifest, clips in _clip_sets(prim):
        if manifest is None:
            continue
        if not path or not manifest.GetPrimAtPath(path):
            yield fault_of(prim, f"clip set {name} has the primPath {path!r}, which its manifest has not")
            continue
        for file, clip in clips:
            held = [p for p in _attributes(clip, path) if clip.ListTimeSamplesForPath(p)] if clip else []
            lacking = [p for p in held if not manifest.GetAttributeAtPath(p)]
            if lacking:
                yield Fault(str(lacking[0]), f"{file} has samples, but the manifest does not declare it")


def clip_times(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a sample at a time at which they are played."""
    api = Usd.ClipsAPI(prim)
    for name, path, _, clips in _clip_sets(prim):
        if api.GetClipTemplateAssetPath(name) or not path:
            continue
        active = [(time, int(index)) for time, index in api.GetClipActive(name) or []]
        unknown = [index for _, index in active if not 0 <= index < len(clips)]
        idle = sorted(set(range(len(clips))) - {index for _, index in active})
        if unknown or idle:
            what = f"activates clip {unknown[0]}" if unknown else f"never activates {clips[idle[0]][0]}"
            yield fault_of(prim, f"clip set {name} {what}; there are {len(clips)} clips")
        times = dict(api.GetClipTimes(name) or [])
        wrong = []
        for time, (file, clip) in ((time, clips[index]) for time, index in active if 0 <= index < len(clips)):
            own = clip.ListAllTimeSamples() if clip else []
            wrong += [(time, file)] if own and times.get(time, time) not in own else []
        if wrong:
            time, file = wrong[0]
            message = f"{file} has no sample at {times.get(time, time):g}, when it is played; {len(wrong)} such"
            yield fault_of(prim, message, time)


def clip_rates(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips of another rate, unit or up axis than the stage, which USD does not convert."""
    root = prim.GetStage().GetRootLayer().pseudoRoot
    for *_, clips in _clip_sets(prim):
        unlike: dict[str, list[str]] = {}
        for file, clip in clips:
            for field in METRICS if clip else ():
                own = clip.pseudoRoot.GetInfo(field) if clip.pseudoRoot.HasInfo(field) else None
                if own is not None and root.HasInfo(field) and own != root.GetInfo(field):
                    unlike.setdefault(f"{field} {own}, the stage {root.GetInfo(field)}", []).append(file)
        for what, files in unlike.items():
            yield fault_of(prim, f"{files[0]} has {what}; {len(files)} such clips")


def _attributes(layer: Sdf.Layer, root: str) -> list[Sdf.Path]:
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path(root), paths.append)
    specs = [layer.GetAttributeAtPath(path) for path in paths if path.IsPropertyPath()]
    return [spec.path for spec in specs if spec and spec.variability == Sdf.VariabilityVarying]
