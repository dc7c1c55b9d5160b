"""Picture of hair by path tracing in Cycles; camera, lamps, backdrop and film are those of the preview.

Blender is under the GNU GPL: only `cycles_program.py` imports it, and only a child process, which ends with this one,
runs that file.
"""

import json
import os
import subprocess
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from signal import SIGKILL, Signals
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from hairpipe.child import command, environment
from hairpipe.errors import BadInput
from hairpipe.render.camera import NEAR, Shot, frame_hair, place_camera
from hairpipe.render.dual_scattering import INDEX, ROUGHNESS, absorption_of
from hairpipe.render.film import EDGE, backdrop
from hairpipe.render.kajiya_kay import TILT, strand_colours
from hairpipe.render.lights import Light, studio
from hairpipe.render.portrait import NOBODY, SCALP, check, drawn_width, relative_widths
from hairpipe.render.skin import CLAY, IRRADIANCE, hair_share
from hairpipe.values import Mesh, Strands
from hairpipe.values.groom import tapers

if TYPE_CHECKING:  # Keys include all imports: they depend on that program, and on the version of bpy.
    from hairpipe.render import cycles_program  # noqa: F401

BOOT = (
    "from hairpipe.child import die_with_parent; die_with_parent();"  # importing Blender takes seconds
    "from hairpipe.render.cycles_program import main; main()"
)
SMALLER = "fewer strands, a smaller picture, or more memory"


def run_blender(scene: dict[str, Any], arrays: dict[str, np.ndarray], folder: Path) -> np.ndarray:
    """Return the image of a scene, see `cycles_program.py`, by Cycles: linear light, (height, width, 3) float32.

    It uses the number of threads of numba; the light does not depend on it. Exchanged files stay in the folder. Raises
    BadInput, in one line, where Blender is not installed or fails.
    """
    if find_spec("bpy") is None:
        mend = "pip install 'hairpipe[cycles]', with Python 3.11 or 3.13"
        raise BadInput("Blender is not installed", where="bpy", right=mend)
    inputs, pixels = folder / "arrays.npz", folder / "pixels.npy"
    np.savez(inputs, **arrays)
    files = {"arrays": str(inputs), "pixels": str(pixels)}
    job = {**scene, **files, "threads": numba.get_num_threads(), "parent": os.getpid()}
    child = subprocess.run(
        command(BOOT),
        input=json.dumps(job).encode(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=environment() | {"TMPDIR": str(folder), "BLENDER_USER_RESOURCES": str(folder)},
    )
    if child.returncode < 0:
        right = SMALLER if -child.returncode == SIGKILL else None
        raise BadInput(f"Blender was ended by {Signals(-child.returncode).name}", where="bpy", right=right)
    if child.returncode > 0:
        *_, last = ["no message", *child.stderr.decode(errors="replace").strip().splitlines()]
        raise BadInput(f"Blender failed: {last}", where="bpy")
    return np.load(pixels)


SOFT = np.radians(12.0)  # angular diameter of a lamp seen from the hair, for soft shadows
FIBRE = {
    "properties": {"model": "CHIANG", "parametrization": "ABSORPTION"},
    "inputs": {"Roughness": ROUGHNESS, "Radial Roughness": ROUGHNESS, "IOR": INDEX, "Offset": TILT},
}
"""Scattering of hair after Chiang, Bitterli, Tappan, Burley 2016; absorption is an attribute of the points."""
SKIN = {"Roughness": 0.6, "Specular IOR Level": 0.2}
"""Inputs of the material of the body, which is matt; its colour is that of the preview."""
FAR = 1e4  # far plane [m]


@dataclass(frozen=True)
class Fibre:
    """Material and drawn width of strands."""

    thickness: float  # drawn width over the width that looks full, see `drawn_width`
    colour: np.ndarray  # of a lock, linear red, green and blue, (3,)


@dataclass(frozen=True)
class Exposure:
    """Sampling of light."""

    samples: int  # paths per pixel
    denoise: bool  # whether OpenImageDenoise removes the noise of few paths
    shutter: float  # exposure time, half before the frame and half after [s], for motion blur; 0: none


def trace_hair(
    hair: Strands, body: Mesh | None, shot: Shot, fibre: Fibre, exposure: Exposure, folder: Path
) -> np.ndarray:
    """Return the light of hair and the body under it at the eye, linear, (height, width, 3) float32, on any threads.

    Raises BadInput where there is no strand, a position or a velocity is not finite, or Blender is not there or fails.
    """
    body = NOBODY if body is None else body
    check(hair, body)
    if exposure.shutter > 0.0 and not (np.isfinite(hair.velocities).all() and np.isfinite(body.rates).all()):
        raise BadInput("a velocity is not finite", where="hair, body", right="shutter = 0 needs none")
    points = np.asarray(hair.points, float)
    framing = frame_hair(points, hair.offsets)
    roots = points[hair.offsets[:-1]]
    strand = np.repeat(np.arange(len(roots)), np.diff(hair.offsets))
    colours = strand_colours(fibre.colour, hair.offsets, strand, 2 * np.arange(len(points)))
    camera = place_camera(replace(shot, grain=1), framing)
    width = fibre.thickness * drawn_width(hair, framing, camera, 1)
    scene = {
        "fibre": FIBRE,
        "skin": {"properties": {}, "inputs": SKIN},
        "lamps": [lamp_of(light) for light in studio(camera.axes)],
        "surroundings": EDGE.tolist(),
        "camera": {
            **{"width": camera.width, "height": camera.height, "nearest": NEAR, "farthest": FAR},
            "angle": 2.0 * np.arctan(0.5 * min(camera.width, camera.height) / camera.focal),
            "axes": rows_of(camera.axes * [[1.0], [1.0], [-1.0]], camera.eye),
        },
        "samples": exposure.samples,
        "denoise": exposure.denoise,
        "blur": exposure.shutter > 0.0,
    }
    share = SCALP * hair_share(body.points, roots, camera.axes)[:, None]
    wall = backdrop(camera.height, camera.width)
    arrays = {
        "hair_points": hair.points,
        "hair_radii": 0.5 * width * relative_widths(hair) * tapers(hair.offsets),
        "hair_moves": exposure.shutter * hair.velocities,
        "hair_offsets": hair.offsets,
        "hair_absorptions": absorption_of(colours),
        "body_points": body.points,
        "body_moves": exposure.shutter * body.rates,
        "body_triangles": body.triangles,
        "body_colours": CLAY + share * (0.5 * fibre.colour - CLAY),
        "wall": np.dstack([wall, np.ones(wall.shape[:2])]),
    }
    return run_blender(scene, arrays, folder)


def lamp_of(light: Light) -> dict[str, Any]:
    """Describe a lamp that lights a sphere as brightly as that of the preview."""
    brightest = light.colour.max()
    aside = np.eye(3)[np.argmin(np.abs(light.towards))]
    right = np.cross(aside, light.towards) / np.linalg.norm(np.cross(aside, light.towards))
    axes = np.stack([right, np.cross(light.towards, right), light.towards])
    colour = (light.colour / brightest).tolist()
    irradiance = IRRADIANCE * brightest
    return {"colour": colour, "irradiance": irradiance, "angle": SOFT, "axes": rows_of(axes, np.zeros(3))}


def rows_of(axes: np.ndarray, origin: np.ndarray) -> list[list[float]]:
    return [[*axis, 0.0] for axis in axes.tolist()] + [[*origin.tolist(), 1.0]]
