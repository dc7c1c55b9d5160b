"""Curves and volumes of a stage, and how they are drawn: purpose, material and frame range."""

from pathlib import Path
from typing import Any, NamedTuple

from pxr import Usd, UsdGeom, UsdShade, UsdVol

from hairpipe.formats.usd.stage import open_stage, usd_faults

INPUTS = ("diffuseColor", "roughness", "ior")
"""Inputs of a UsdPreviewSurface that a shader for hair has, too."""


class Drawn(NamedTuple):
    """Looks of a stage.

    prims   of each curve and volume by its name: type, purpose, and name and inputs of its material
    frames  first and last time code, and time codes per second; None without time codes
    """

    prims: dict[str, dict[str, Any]]
    frames: tuple[float, float, float] | None


def find_drawn(path: Path) -> Drawn:
    """Find the curves and volumes of a stage.

    Raises BadInput where the file cannot be read.
    """
    with usd_faults(path):
        stage = open_stage(path)
        shapes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Curves) or p.IsA(UsdVol.Volume)]
        found = {shape.GetName(): look_of(shape) for shape in shapes}
        timed = stage.HasAuthoredTimeCodeRange()
        times = (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond())
        return Drawn(found, times if timed else None)


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
