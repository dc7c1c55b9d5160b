"""Hair on its way through a frame, and the steps of time that advance it."""

from dataclasses import dataclass, field

import numpy as np

from hairpipe.data.hair import HairState
from hairpipe.sim.boundary import ClampPath


@dataclass(eq=False)
class State:
    """State of hair within a frame; integrators change it in place.

    x, v   positions [m] and velocities [m/s], (rows, 3, W)
    a      accelerations of the last stage [m/s^2], (rows, 3, W)
    T      tensions of the springs in the last solve [N], (rows, springs, W)
    fresh  strands whose forces jumped afterwards: their accelerations are invalid, (blocks, W) bool
    held   number of steps since the last frame without a solution for each strand, see `integrators/lost.py`,
           (blocks, W) int64
    failed number of steps since the last frame without a solution for any strand
    """

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    T: np.ndarray
    fresh: np.ndarray
    held: np.ndarray = field(init=False)
    failed: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.held = np.zeros(self.fresh.shape, np.int64)

    @classmethod
    def begin(cls, state: HairState, x: np.ndarray) -> "State":
        """Copy the state that a frame begins with; x is where its particles are, about an origin [m], (rows, 3, W)."""
        arrays = x, state.velocities, state.accelerations, state.tensions, state.fresh
        return cls(*(array.copy() for array in arrays))


@dataclass(frozen=True, eq=False)
class Step:
    """A step on the path of the clamped particles: it begins at a time since the last frame and lasts dt [s]."""

    path: ClampPath
    time: float
    dt: float

    def ends(self, part: float) -> np.ndarray:
        """Find the clamped particles after a part of the step, 0 to 1 [m], (blocks, 2 clamped, 3, W)."""
        return self.path.ends(self.time + part * self.dt)

    @property
    def held(self) -> np.ndarray:
        """1 where the tip of a strand is held, (blocks, W); no rows where all are free."""
        return self.path.held
