"""Rules for the files that a stage refers to; OpenUSD has no validator of their paths, nor of OpenVDB."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from pxr import Ar, Sdf, Tf, Usd, UsdVol

from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.layer_files import clip_names
from hairpipe.formats.usd.stage import message_of
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
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    for path in paths:
        spec = layer.GetObjectAtPath(path)
        if isinstance(spec, Sdf.PrimSpec):
            yield from (Asset(layer, str(path), name) for name in _composed(spec))
            yield from (Asset(layer, str(path), name, data=True) for name in clip_names(spec))
        elif isinstance(spec, Sdf.AttributeSpec) and spec.typeName.scalarType == Sdf.ValueTypeNames.Asset:
            yield from _values(layer, spec)


def _composed(spec: Sdf.PrimSpec) -> Iterator[str]:
    """Name the files of references and payloads."""
    for arcs in (spec.referenceList, spec.payloadList):
        yield from (arc.assetPath for arc in arcs.GetAddedOrExplicitItems() if arc.assetPath)


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


class Grid(Protocol):
    """Header of a grid of an OpenVDB file."""

    @property
    def name(self) -> str:
        """The name."""
        ...

    @property
    def grid_class(self) -> str:
        """The class, in OpenVDB's words."""
        ...


Inspect = Callable[[Path], Sequence[Grid]]
"""Lists the grids of an OpenVDB file; raises BadInput for another file."""


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
                yield Fault(str(attribute.GetPath()), message, time)


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


RULES = (
    Rule("missing-file", "error", missing_file),
    Rule("broken-layer", "error", broken_layer),
    Rule("absolute-path", "warning", absolute_path),
)
PRIM_RULES = (Rule("openvdb-grid", "error", openvdb_grid),)
