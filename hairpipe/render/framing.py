"""Placement of the camera: the hair fills the picture, independent of its motion."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from hairpipe.data.lengths import strand_lengths
from hairpipe.render.camera import Camera

View = Literal["three_quarter", "front", "side", "back"]
Place = tuple[float, float, float]

GRAIN = 2
"""Pixels of the film across one pixel of a picture, for high quality."""
AZIMUTHS = {"three_quarter": 38.0, "front": 0.0, "side": 90.0, "back": 180.0}
"""Azimuth of the eye about the up axis, from where the face looks (+Z) towards the left ear (+X) [degrees]."""
ELEVATION = 6.0
"""Elevation of the eye above the horizon [degrees]."""
DROP = 0.3
"""Distance of the centre of the picture below that of the roots, over its radius."""


@dataclass(frozen=True)
class Shot:
    """Camera settings of a picture; an eye and a target override those from the view and the hair.

    width   of the picture [pixels]
    height  of the picture [pixels]
    view    side of the head
    fov     field of view across the shorter side [degrees]
    eye     position of the camera [m]
    target  point at the centre of the picture [m]
    grain   pixels of the film across one of the picture
    turn    rotation of the eye about the target, towards the left ear [degrees]
    radius  half the length of the shorter side at the target, in place of that of the hair [m]
    """

    width: int
    height: int
    view: View = "three_quarter"
    fov: float = 24.0
    eye: Place | None = None
    target: Place | None = None
    grain: int = GRAIN
    turn: float = 0.0
    radius: float | None = None


@dataclass(frozen=True)
class Framing:
    """Area of a picture.

    target  centre of the picture [m], (3,) float64
    radius  half the length of its shorter side at the target [m]
    """

    target: np.ndarray
    radius: float


def frame_hair(points: np.ndarray, offsets: np.ndarray, radius: float | None = None) -> Framing:
    """Frame the hair by its roots and its length, not by its positions.

    The spread of the roots and the median length of the strands are constant while the hair moves: the scale of the
    picture is constant, and its centre moves with the roots only.

    points   root first, strand after strand [m], (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    radius   of the picture [m]; None for that of this hair
    """
    roots = points[offsets[:-1]]
    centre = roots.mean(axis=0)
    if radius is None:
        radius = radius_of(points, offsets)
    return Framing(centre - [0.0, DROP * radius, 0.0], radius)


def radius_of(points: np.ndarray, offsets: np.ndarray) -> float:
    """Return the radius of a picture of hair [m]; arguments as of `frame_hair`."""
    roots = points[offsets[:-1]]
    centre = roots.mean(axis=0)
    spread = float(np.sqrt(np.mean(np.sum((roots - centre) ** 2, axis=1))))
    length = float(np.median(strand_lengths(points, offsets)))
    return max(1.6 * spread + 0.65 * length, 1e-3)


def place_camera(shot: Shot, framing: Framing) -> Camera:
    """Place the camera as set by the shot; by default, so that the framed hair fills the film."""
    target = framing.target if shot.target is None else np.array(shot.target)
    azimuth = np.radians(AZIMUTHS[shot.view])
    elevation = np.radians(ELEVATION)
    level = np.cos(elevation)
    towards = np.array([level * np.sin(azimuth), np.sin(elevation), level * np.cos(azimuth)])
    distance = framing.radius / np.tan(0.5 * np.radians(shot.fov))
    eye = target + distance * towards if shot.eye is None else np.array(shot.eye)
    around = np.radians(shot.turn)
    c = np.cos(around)
    s = np.sin(around)
    eye = target + np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ (eye - target)
    return Camera.look_at(eye, target, shot.fov, shot.width, shot.height).enlarged(shot.grain)
