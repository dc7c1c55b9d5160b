"""Interface of time integrators."""

from typing import Protocol

import numpy as np

from hairpipe.sim.state import State, Step
from hairpipe.sim.strands.interface import StrandModel
from hairpipe.sim.surroundings import Surroundings


class Integrator(Protocol):
    """Carries hair through a step: solves with what surrounds it, and filters where its scheme has them."""

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        ...


def everywhere(model: StrandModel, like: np.ndarray, number: float) -> np.ndarray:
    """Return a number for every strand, (blocks, W), of the dtype of (rows, 3, W)."""
    return np.full((len(model.first) - 1, like.shape[2]), number, like.dtype)


def rows_of(model: StrandModel, lanes: np.ndarray) -> np.ndarray:
    """Repeat what every strand has, (blocks, W), for its particles, (rows, 1, W)."""
    return np.repeat(lanes, np.diff(model.first), axis=0)[:, None]
