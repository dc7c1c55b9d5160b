"""Stage of one mesh, or of hair, at one frame."""

from pathlib import Path

import numpy as np
from pxr import UsdGeom

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.io.groom_shot import DIAMETER
from hairpipe.io.usd.samples import sample_body
from hairpipe.io.usd.shot import Shot, write_shot
from hairpipe.io.usd.stage import create_stage
from hairpipe.io.usd.statics import author_body


def write_still(path: Path, value: Mesh | Strands | Groom, frame: int, fps: float) -> None:
    """Write the shape at a frame, with the prims and attributes of a shot.

    frame  number, which becomes the one time code
    fps    frames per second [1/s]

    Raises BadInput where points are not finite.
    """
    if isinstance(value, Mesh):
        write_mesh(path, value, frame, fps)
    elif isinstance(value, Groom):
        strands = Strands(value.points, np.zeros_like(value.points, np.float32), value.offsets, DIAMETER)
        write_shot(path, Shot({frame: strands}, None, value, fps))
    else:
        write_shot(path, Shot({frame: value}, None, None, fps))


def write_mesh(path: Path, mesh: Mesh, frame: int, fps: float) -> None:
    """Write a mesh at a frame."""
    stage = create_stage(path, fps)
    stage.SetStartTimeCode(frame)
    stage.SetEndTimeCode(frame)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/shot").GetPrim())
    body = UsdGeom.Mesh.Define(stage, "/shot/body")
    author_body(body, mesh)
    sample_body(body, frame, mesh, mesh)
    stage.Save()
