"""Shapes modelled as the zero set of a blended distance field: ellipsoids and cones, joined or carved smoothly."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

Vector = tuple[float, float, float]

CHUNK = 16384  # points evaluated together: the temporaries of one stroke stay in the second-level cache


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid turned about the x, y and z axis in that order."""

    centre: Vector  # [m]
    radii: Vector  # along its own axes [m]
    turn: Vector = (0.0, 0.0, 0.0)  # angles about x, y, z [deg]

    @cached_property
    def axes(self) -> np.ndarray:
        """World directions of its axes, as columns (3, 3)."""
        return axis_rotation(2, self.turn[2]) @ axis_rotation(1, self.turn[1]) @ axis_rotation(0, self.turn[0])

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Estimate the signed distance [m] of points (n, 3): k (k - 1) / |grad k|, exact to first order."""
        local = (points - np.array(self.centre)) @ self.axes
        scaled = local / np.array(self.radii)
        level = np.sqrt(np.einsum("ij,ij->i", scaled, scaled))
        scaled /= np.array(self.radii)
        slope = np.sqrt(np.einsum("ij,ij->i", scaled, scaled))
        return level * (level - 1.0) / np.maximum(slope, 1e-9)


@dataclass(frozen=True)
class Cone:
    """A line whose thickness changes from one end to the other, with round ends."""

    start: Vector  # [m]
    end: Vector  # [m]
    radii: tuple[float, float]  # at both [m]

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Estimate the signed distance [m] of points (n, 3): to the axis, less the radius there."""
        axis = np.array(self.end) - np.array(self.start)
        local = points - np.array(self.start)
        along = np.clip(local @ axis / (axis @ axis), 0.0, 1.0)
        local -= along[:, None] * axis
        radius = self.radii[0] + along * (self.radii[1] - self.radii[0])
        return np.sqrt(np.einsum("ij,ij->i", local, local)) - radius


@dataclass(frozen=True)
class Stroke:
    """One step of modelling: join a part to the shape made so far, or carve it away."""

    part: Ellipsoid | Cone
    blend: float  # width of the smooth transition [m]
    carve: bool = False
    mirror: bool = False  # whether the same is done at the other side of the plane x = 0


MIRROR_ROUNDING = 0.003  # mirrored parts see sqrt(x^2 + this^2) for |x|: no crease in the middle


def evaluate(strokes: tuple[Stroke, ...], points: np.ndarray) -> np.ndarray:
    """Return the signed distance estimate [m] of the shape at points (n, 3), negative inside, (n,). Pure."""
    result = np.empty(len(points))
    for first in range(0, len(points), CHUNK):
        chunk = points[first : first + CHUNK]
        mirrored = chunk.copy()
        mirrored[:, 0] = np.sqrt(chunk[:, 0] ** 2 + MIRROR_ROUNDING**2)
        field = strokes[0].part.distance(mirrored if strokes[0].mirror else chunk)
        for stroke in strokes[1:]:
            other = stroke.part.distance(mirrored if stroke.mirror else chunk)
            # The maximum of a field and the negative of another is the negative of a minimum.
            sign = -1.0 if stroke.carve else 1.0
            field = sign * smooth_min(sign * field, other, stroke.blend)
        result[first : first + CHUNK] = field
    return result


def gradient(strokes: tuple[Stroke, ...], points: np.ndarray, step: float = 2e-4) -> np.ndarray:
    """Return the gradient of the field by central differences over `step` [m], (n, 3). Pure."""
    columns = []
    for axis in np.eye(3) * step:
        columns.append((evaluate(strokes, points + axis) - evaluate(strokes, points - axis)) / (2.0 * step))
    return np.stack(columns, axis=1)


def project(strokes: tuple[Stroke, ...], points: np.ndarray, steps: int = 1) -> np.ndarray:
    """Move points (n, 3) onto the surface by Newton steps x - f grad f / |grad f|^2. Pure."""
    for _ in range(steps):
        slope = gradient(strokes, points)
        square = np.maximum(np.einsum("ij,ij->i", slope, slope), 1e-6)
        points = points - (evaluate(strokes, points) / square)[:, None] * slope
    return points


def smooth_min(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """Return the minimum of two fields, rounded with continuous curvature where they differ by < `width` [m]."""
    overlap = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - overlap * overlap * overlap * (width / 6.0)


def axis_rotation(axis: int, degrees: float) -> np.ndarray:
    """Return the right-handed rotation about coordinate axis 0, 1 or 2, (3, 3), column vectors."""
    cosine = np.cos(np.radians(degrees))
    sine = np.sin(np.radians(degrees))
    second, third = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[second, second] = matrix[third, third] = cosine
    matrix[third, second] = sine
    matrix[second, third] = -sine
    return matrix
