"""A pinhole camera, Y up, and its placement: the hair fills the picture, independent of its motion."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values.groom import strand_lengths

NEAR = 0.01
"""Near plane [m]."""


@dataclass(frozen=True)
class Camera:
    """Position, axes and film of a camera."""

    eye: np.ndarray  # position of the pinhole [m], (3,) float64
    axes: np.ndarray  # rows are the unit vectors to the right, up and into the picture, (3, 3) float64
    focal: float  # focal length [pixels]
    width: int  # of the film [pixels]
    height: int  # of the film [pixels]

    @classmethod
    def look_at(cls, eye: np.ndarray, target: np.ndarray, fov: float, width: int, height: int) -> Self:
        """Look from the eye at the target, upright; the shorter side of the film sees `fov` degrees."""
        ahead = np.asarray(target, float) - np.asarray(eye, float)
        distance = np.linalg.norm(ahead)
        if not distance > NEAR:
            raise BadInput("the eye is at the target", where="eye, target", right=f"a distance of more than {NEAR} m")
        ahead /= distance
        upright = np.array([0.0, 1.0, 0.0]) if abs(ahead[1]) < 0.999 else np.array([0.0, 0.0, -1.0])
        right = np.cross(ahead, upright)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(right, ahead), ahead])
        focal = 0.5 * min(width, height) / np.tan(0.5 * np.radians(fov))
        return cls(np.array(eye, float), axes, float(focal), width, height)

    def see(self, points: np.ndarray) -> np.ndarray:
        """Coordinates along the axes of the camera, from the eye [m], (n, 3) float64."""
        return (points - self.eye) @ self.axes.T

    def project(self, points: np.ndarray) -> np.ndarray:
        """Film column and row [pixels] and depth along the view axis [m], (n, 3) float64.

        column = width/2 + focal x/z, row = height/2 - focal y/z; pixel (i, j) has its centre at row i + 1/2 and column
        j + 1/2. Points of a depth below NEAR are not on the film: column and row say nothing there.
        """
        places = self.see(points)
        scale = self.focal / np.maximum(places[:, 2], NEAR)
        places[:, 0] = self.width / 2 + scale * places[:, 0]
        places[:, 1] = self.height / 2 - scale * places[:, 1]
        return places

    def enlarged(self, times: int) -> Self:
        """Return the same view on a film of so many times the pixels across."""
        return type(self)(self.eye, self.axes, self.focal * times, self.width * times, self.height * times)


View = Literal["three_quarter", "front", "side", "back"]
Place = tuple[float, float, float]

GRAIN = 2  # pixels of the film across one pixel of a picture, for high quality
AZIMUTHS = {"three_quarter": 38.0, "front": 0.0, "side": 90.0, "back": 180.0}
"""Azimuth of the eye about the up axis, from where the face looks (+Z) towards the left ear (+X) [degrees]."""
ELEVATION = 6.0  # elevation of the eye above the horizon [degrees]
DROP = 0.3  # distance of the centre of the picture below that of the roots, over its radius


@dataclass(frozen=True)
class Shot:
    """Camera settings of a picture; an eye and a target override those from the view and the hair."""

    width: int  # of the picture [pixels]
    height: int  # of the picture [pixels]
    view: View = "three_quarter"
    fov: float = 24.0  # field of view across the shorter side [degrees]
    eye: Place | None = None  # position of the camera [m]
    target: Place | None = None  # point at the centre of the picture [m]
    grain: int = GRAIN  # pixels of the film across one of the picture
    turn: float = 0.0  # rotation of the eye about the target, towards the left ear [degrees]
    radius: float | None = None  # half the length of the shorter side at the target, by default that of the hair [m]


@dataclass(frozen=True)
class Framing:
    """Area of a picture."""

    target: np.ndarray  # centre of the picture [m], (3,) float64
    radius: float  # half the length of its shorter side at the target [m]


def frame_hair(points: np.ndarray, offsets: np.ndarray, radius: float | None = None) -> Framing:
    """Frame the hair by its roots and its length, not by its positions, with a radius [m] or that of this hair.

    The spread of the roots and the median length of the strands are constant while the hair moves: the scale of the
    picture is constant, and its centre moves with the roots only.
    """
    roots = points[offsets[:-1]]
    centre = roots.mean(axis=0)
    if radius is None:
        radius = radius_of(points, offsets)
    return Framing(centre - [0.0, DROP * radius, 0.0], radius)


def radius_of(points: np.ndarray, offsets: np.ndarray) -> float:
    """Return the radius of a picture of hair [m]."""
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
