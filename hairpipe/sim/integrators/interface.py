"""What a time integrator is given, and what it does."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from hairpipe.sim.models.chain import Chain
from hairpipe.sim.models.network import Network
from hairpipe.sim.roots import Path

if TYPE_CHECKING:
    from hairpipe.sim.surroundings import Surroundings


@dataclass(eq=False)
class Motion:
    """Hair on its way through a frame; integrators change it in place.

    x, v  positions [m] and velocities [m/s], (rows, 3, W)
    a     accelerations of the last stage [m/s^2], (rows, 3, W)
    T     tensions of the springs as the last solve found them [N], (rows, springs, W)
    """

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    T: np.ndarray


@dataclass(frozen=True, eq=False)
class Step:
    """A step of time on the path of the held particles; it begins at a time since the last frame and lasts dt [s]."""

    path: Path
    time: float
    dt: float

    def ends(self, part: float) -> np.ndarray:
        """Find the held particles after a part of the step, 0 to 1 [m], (blocks, 2 clamped, 3, W)."""
        return self.path.ends(self.time + part * self.dt)

    @property
    def held(self) -> np.ndarray:
        """1 where the tip of a strand is held, (blocks, W); no rows where all are free."""
        return self.path.held


class Integrator(Protocol):
    """Carries hair through a step: solves with what surrounds it, and filters where its scheme has them."""

    def advance(self, model: Network | Chain, motion: Motion, step: Step, around: "Surroundings") -> None:
        """Advance motion by step, in place."""
        ...


def everywhere(model: Network | Chain, like: np.ndarray, number: float) -> np.ndarray:
    """Give every strand a number, (blocks, W), of the dtype of (rows, 3, W)."""
    return np.full((len(model.first) - 1, like.shape[2]), number, like.dtype)


def rows_of(model: Network | Chain, lanes: np.ndarray) -> np.ndarray:
    """Repeat what every strand has, (blocks, W), for its particles, (rows, 1, W)."""
    return np.repeat(lanes, np.diff(model.first), axis=0)[:, None]
