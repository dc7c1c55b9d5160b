"""Hair on its way through a frame, and the steps that it goes in."""

from dataclasses import dataclass

import numpy as np

from hairpipe.sim.boundary import ClampPath


@dataclass(eq=False)
class State:
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

    path: ClampPath
    time: float
    dt: float

    def ends(self, part: float) -> np.ndarray:
        """Find the held particles after a part of the step, 0 to 1 [m], (blocks, 2 clamped, 3, W)."""
        return self.path.ends(self.time + part * self.dt)

    @property
    def held(self) -> np.ndarray:
        """1 where the tip of a strand is held, (blocks, W); no rows where all are free."""
        return self.path.held
