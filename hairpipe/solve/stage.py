"""Records that travel whole into the kernels of a stage.

Hair on its way through a frame, and the steps of time that advance it.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from hairpipe.solve.boundary import ClampPath
from hairpipe.strands.interface import StiffnessPart
from hairpipe.values.hair import HairState


class Rule(NamedTuple):
    """Parameters common to all stages of a simulation.

    form        a SpringForm
    damping     damping of the springs, a fraction of critical damping
    guard       strain of an edge at the guess beyond which its strand restarts from the start of its stage, at its
    root,
                in two iterations, or with external forces, from the result of `guess_stages`; inf: never
    iterations  number of Newton iterations per stage
    gravity     [m/s^2], (3,)
    drag        drag in still air [1/s]
    part        part of the stiffness of models whose matrix may be indefinite, a StiffnessPart
    """

    form: int
    damping: float
    guard: float
    iterations: int
    gravity: np.ndarray
    drag: float
    part: int = int(StiffnessPart.full)


class Stage(NamedTuple):
    """One stage of an integrator: x = xh + h v, M (v - vh) = h f(x, v), for all strands or one block.

    xh, vh  explicit parts of position [m] and velocity [m/s], (rows, 3, W)
    before  positions at its start, same shape; a strand that the guess strains too much restarts there
    began   velocities at its start, same shape: the guess, or the velocities for drag and friction if the guess differs
    ends    held particles at its end: those at the root, then those at the tip [m], (blocks, 2 clamped, 3, W)
    held    1 if the tip is held, 0 if it is free, (blocks, W); no rows if all are free
    h       weight of the end, for every strand [s], (blocks, W)
    time    time of bodies and wind since the previous frame: its end, except in the nine steps [s]
    span    duration of the stage [s]
    """

    xh: np.ndarray
    vh: np.ndarray
    before: np.ndarray
    began: np.ndarray
    ends: np.ndarray
    held: np.ndarray
    h: np.ndarray
    time: float
    span: float


class Iterate(NamedTuple):
    """Iterate of Newton's method, of all strands or of one block; kernels change it in place.

    x, v  positions [m] and velocities [m/s], (rows, 3, W)
    T     tensions of the springs in the last solve [N], and other results that a model stores, in the shape of its
          inverse_lengths, (rows, springs, W)
    """

    x: np.ndarray
    v: np.ndarray
    T: np.ndarray


class System(NamedTuple):
    """Banded systems of strands, of all or of one block.

    A  factors, (rows, row_size, W), possibly in lower precision; no rows if they are not kept
    b  right-hand side, then the change of velocity [m/s], and of other unknowns of a row, (rows, unknowns, W)
    """

    A: np.ndarray
    b: np.ndarray


@dataclass(eq=False)
class State:
    """State of hair within a frame; integrators change it in place.

    x, v   positions [m] and velocities [m/s], (rows, 3, W)
    a      accelerations of the last stage [m/s^2], (rows, 3, W)
    T      tensions of the springs in the last solve [N], (rows, springs, W)
    fresh  strands whose forces jumped afterwards: their accelerations are invalid, (blocks, W) bool
    held   number of steps since the last frame without a solution for each strand, see `solve/lost.py`,
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
