"""Rules for level sets over time: those of a moving body change."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdVol

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Scene
from hairpipe.plain_file import special

LEAST = 1000  # bytes of a file that holds a level set
MOVED = 1e-3  # of its size, by which a body has moved


def volume_still(scene: Scene) -> Iterator[Fault]:
    """Find one level set for all frames while the body moves: one file, or files of one content."""
    if not any(_has_moved(scene, index) for index in range(len(scene.meshes))):
        return
    for prim in scene.stage.Traverse():
        if not prim.IsA(UsdVol.OpenVDBAsset) or _is_placed(prim):
            continue
        attribute = UsdVol.OpenVDBAsset(prim).GetFilePathAttr()
        times = attribute.GetTimeSamples()
        assets = [attribute.Get(time) for time in times] if times else [attribute.Get()]
        files = {asset.path for asset in assets if asset}
        contents = {_content(asset) for asset in assets if asset}
        if len(files) == 1 or (len(contents) == 1 and None not in contents):
            yield Fault(
                str(attribute.GetPath()), "is one level set at all frames, but the body moves; export one a frame"
            )


def _has_moved(scene: Scene, index: int) -> bool:
    """Return whether a mesh has moved at its last time, or at half of its times."""
    mesh = scene.meshes[index]
    times = mesh.points if mesh.moves else _range(scene.stage)
    if not scene.moves(mesh) or len(times) < 2:
        return False
    places = [scene.place(mesh, time) for time in (times[0], times[len(times) // 2], times[-1])]
    size = float(np.linalg.norm(np.ptp(places[0], axis=0))) if len(places[0]) else 0.0
    return any(len(p) == len(places[0]) and np.abs(p - places[0]).max() > MOVED * size for p in places[1:] if size)


def _range(stage: Usd.Stage) -> list[float]:
    return [stage.GetStartTimeCode(), stage.GetEndTimeCode()] if stage.HasAuthoredTimeCodeRange() else []


def _is_placed(prim: Usd.Prim) -> bool:
    """Return whether a transform moves a field: that of the body may."""
    while prim.IsA(UsdGeom.Xformable):
        if UsdGeom.Xformable(prim).TransformMightBeTimeVarying():
            return True
        prim = prim.GetParent()
    return False


def _content(asset: Sdf.AssetPath) -> bytes | None:
    """Return a digest of a file; None where it is not one, or too small to hold a level set."""
    path = Path(asset.resolvedPath)
    if not asset.resolvedPath or special(path) or not path.is_file() or path.stat().st_size < LEAST:
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "blake2b").digest()


RULES = (Rule("volume-still", "error", volume_still),)
