"""Files of a stage, checked before OpenUSD composes them: opening a pipe or a device may never return."""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Tf

from hairpipe.errors import BadInput
from hairpipe.plain_file import special_kind

TEMPLATE = 100_000  # maximum number of files of a template


@dataclass(frozen=True)
class Layers:
    """Layers of a stage.

    open   layers; OpenUSD does not read them again while they are referred to
    sizes  of their files, and of those of value clips, by path [bytes]; 0 where one is missing
    """

    open: list[Sdf.Layer]
    sizes: dict[str, int]

    @property
    def bytes(self) -> int:
        """Size of all files."""
        return sum(self.sizes.values())


def list_files(path: Path) -> list[Path]:
    """Return the files that a stage is composed of, that of the path first, and those that do not exist."""
    return [Path(file) for file in find_layers(path).sizes]


def with_folders(files: Iterable[Path]) -> list[Path]:
    """Return files and their folders, which change where another file appears that a stage refers to; pure."""
    return list(dict.fromkeys(place for file in files for place in (file, file.parent)))


def find_layers(path: Path) -> Layers:
    """Open all layers of a stage, and find the files of its value clips.

    Composition reports missing or damaged ones, see `hairpipe.formats.usd.stage`.

    Raises BadInput if one of them is not a regular file.
    """
    found = list[Sdf.Layer]()
    sizes = dict[str, int]()
    pending = [str(path)]
    while pending:
        file = pending.pop()
        if file in sizes:
            continue
        sizes[file] = _plain_size(file, path)
        layer = _open_layer(file)
        if layer is not None:
            found.append(layer)
            pending += _files(layer, layer.GetCompositionAssetDependencies())
            sizes |= {clip: _plain_size(clip, path) for clip in _files(layer, _clips_of(layer)) if clip not in sizes}
    return Layers(found, sizes)


def _clips_of(layer: Sdf.Layer) -> Iterator[str]:
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    for path in paths:
        spec = layer.GetObjectAtPath(path)
        if isinstance(spec, Sdf.PrimSpec):
            yield from clip_names(spec)


def clip_names(spec: Sdf.PrimSpec) -> Iterator[str]:
    """Name the files of the value clips of a prim."""
    for clips in (spec.GetInfo("clips") or {}).values():
        if isinstance(clips, dict):
            yield from _in_clips(clips)


def _in_clips(clips: dict[str, Any]) -> Iterator[str]:
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


def _files(layer: Sdf.Layer, names: Iterable[str]) -> list[str]:
    """Return the files of the names in a layer; for a file in a package, the package."""
    return [resolve(layer, name) for name in names if name]


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


def _open_layer(file: str) -> Sdf.Layer | None:
    """Open a layer; None for a file that OpenUSD cannot read."""
    try:
        return Sdf.Layer.FindOrOpen(file)
    except (Tf.ErrorException, UnicodeDecodeError):
        return None
