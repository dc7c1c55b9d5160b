"""A triangle mesh at one instant."""

import numpy as np

from hairpipe.data.value import value


@value
class Mesh:
    """Triangles in space, with the velocities of the vertices if they move.

    points      positions [m], (n, 3) float64
    triangles   vertex indices, counter-clockwise seen from outside, (m, 3) int32
    velocities  of the vertices [m/s], (n, 3) float64, or None for a static mesh
    uv          texture coordinates of the triangle corners, (m, 3, 2) float32, or None
    """

    points: np.ndarray
    triangles: np.ndarray
    velocities: np.ndarray | None = None
    uv: np.ndarray | None = None

    @property
    def rates(self) -> np.ndarray:
        """Velocities of the vertices, 0 where the mesh does not move [m/s], (n, 3) float64."""
        return np.zeros_like(self.points) if self.velocities is None else self.velocities
