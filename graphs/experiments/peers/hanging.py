"""The scenes that all solvers share: straight strands, clamped at roots that are fixed, released under gravity."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from hairpipe.strands.material import Material

FRAME = 1 / 60
"""Duration of a frame [s]."""


@dataclass(frozen=True)
class Hanging:
    """Equal strands that do not touch each other.

    length    of a strand [m]
    angle     at the start, from hanging straight down, in the plane of x and y [deg]
    gravity   along -y [m/s^2]
    drag      damping rate of velocities [1/s]
    seconds   duration [s]
    material  of the fibre; solvers divide EA and GA by its softening, or say what else they do
    """

    length: float
    angle: float
    gravity: float = 9.81
    drag: float = 0.0
    seconds: float = 1.0
    material: Material = field(default_factory=Material)

    @property
    def direction(self) -> np.ndarray:
        """Unit vector from the root to the tip at the start, (3,)."""
        angle = np.radians(self.angle)
        return np.array([np.sin(angle), -np.cos(angle), 0.0])

    @property
    def frames(self) -> int:
        """Number of frames."""
        return round(self.seconds / FRAME)

    def centred(self, segments: int) -> float:
        """Length of a segment [m] where the first one is held with its middle at the root.

        For solvers that clamp a whole segment: the clamp is then at the root to second order.
        """
        return self.length / (segments - 0.5)


class Strands(Protocol):
    """Strands in a solver, from the start on."""

    def advance(self) -> None:
        """Advance by a frame."""
        ...

    def points(self) -> np.ndarray:
        """Points of the first strand [m], (n, 3); the last is the tip, distances at the start are those at rest."""
        ...


class Peer(NamedTuple):
    """A solver with the settings that it is judged with.

    solver    name and version
    settings  in words
    segments  of a strand
    steps     a frame
    strands   to time: as many as fill its vectors and threads
    lay       the strands of a scene, by their number
    """

    solver: str
    settings: str
    segments: int
    steps: int
    strands: int
    lay: Callable[[Hanging, int], Strands]
