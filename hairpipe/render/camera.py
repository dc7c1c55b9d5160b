"""A pinhole camera, Y up."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hairpipe.errors import BadInput

NEAR = 0.01
"""Near plane [m]."""


@dataclass(frozen=True)
class Camera:
    """Position, axes and film of a camera.

    eye     position of the pinhole [m], (3,) float64
    axes    rows are the unit vectors to the right, up and into the picture, (3, 3) float64
    focal   focal length [pixels]
    width   of the film [pixels]
    height  of the film [pixels]
    """

    eye: np.ndarray
    axes: np.ndarray
    focal: float
    width: int
    height: int

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
