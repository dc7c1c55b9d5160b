"""Level set of the body as a volume, with fields in OpenVDB files next to the stage, one per frame."""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdVol, Vt

from hairpipe.errors import BadInput

NAME = "levelset"
FIELDS = {"surface": ("float", "levelSet"), "vel": ("float3", "")}
"""Grids of a file, their type and class."""


@dataclass(frozen=True)
class VolumeFile:
    """An OpenVDB file with the grids `surface` and `vel`, in metres.

    path  where it lies now
    box   lower and upper corner of its active voxels [m]
    """

    path: Path
    box: tuple[tuple[float, ...], tuple[float, ...]]


def write_volume(stage: Usd.Stage, name: str, files: Mapping[int, VolumeFile]) -> dict[str, Path]:
    """Author a volume under the default prim, of purpose guide, and copy its files next to the stage.

    Returns the files by the names, relative to the stage, under which it refers to them.

    Raises BadInput if there are none.
    """
    if not files:
        raise BadInput("there are no level sets to export", where="volume", right="at least one frame")
    volume = UsdVol.Volume.Define(stage, stage.GetDefaultPrim().GetPath().AppendChild(NAME))
    volume.CreatePurposeAttr(UsdGeom.Tokens.guide)
    named = {f"{name}.volume/{name}.{frame:04d}.vdb": file.path for frame, file in files.items()}
    assets = dict(zip(files, (Sdf.AssetPath(f"./{name}") for name in named), strict=True))
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
    _author_boxes(volume, files)
    return _copy(Path(stage.GetRootLayer().realPath).parent, named)


def _author_boxes(volume: UsdVol.Volume, files: Mapping[int, VolumeFile]) -> None:
    boxes = {frame: Vt.Vec3fArray([Gf.Vec3f(*corner) for corner in file.box]) for frame, file in files.items()}
    volume.CreateExtentAttr(next(iter(boxes.values())))
    for frame, box in boxes.items():
        volume.GetExtentAttr().Set(box, frame)


def _copy(folder: Path, named: Mapping[str, Path]) -> dict[str, Path]:
    for name, path in named.items():
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copyfile(path, folder / name)
    return {name: folder / name for name in named}
