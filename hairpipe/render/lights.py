"""The lamps of the studio."""

from typing import NamedTuple, Protocol

import numpy as np


class Light(NamedTuple):
    """A distant lamp."""

    towards: np.ndarray  # unit vector towards it, (3,) float64
    colour: np.ndarray  # of its light, linear red, green and blue, (3,) float64


class Shade(Protocol):
    """The shadow of a scene in the light of one lamp."""

    @property
    def light(self) -> Light: ...

    @property
    def cell(self) -> float: ...  # resolution of the shadow across the light [m]

    def between(self, points: np.ndarray) -> np.ndarray:
        """Optical depths between the lamp and world points (n, 3): hairs that a ray crosses, (n,) float64."""
        ...


# Towards the lamp (right, up, to the viewer) and its colour. A warm key from the upper left, a cool fill from the
# right, a strong rim from behind for the outline of the hair, and the sky.
STUDIO = (
    ((-0.4, 0.62, 0.67), (2.8, 2.55, 2.25)),
    ((0.85, 0.25, 0.5), (0.8, 0.85, 0.95)),
    ((0.5, 0.55, -0.67), (2.2, 2.2, 2.3)),
    ((0.0, 0.98, 0.2), (0.6, 0.63, 0.7)),
)


def studio(axes: np.ndarray) -> list[Light]:
    """Place the lamps relative to a camera with these axes, (3, 3), so that all views have the same light."""
    viewer = axes * [[1.0], [1.0], [-1.0]]
    return [Light(np.array(to) @ viewer / np.linalg.norm(to), np.array(colour)) for to, colour in STUDIO]
