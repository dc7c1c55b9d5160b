"""The full state of a hair simulation between two frames."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class HairState:
    """Everything the next frame needs, in the simulation's own layout: particles in rows, strands in the last axis.

    positions        in the world [m], (rows, 3, lanes) float64
    velocities       [m/s], same shape, float64, or float32 where hair is computed in that
    accelerations    that the last step found [m/s^2], same shape and precision
    fresh            strands whose forces have jumped since, so that accelerations do not count, (blocks, lanes) bool
    tensions         multipliers of the springs to the next particles [N], (rows, springs, lanes)
    inverse_lengths  1 / rest length of those springs [1/m], same shape; None where they rest in the groom's shape
    stuck            segments of the groom that stick together, first < second, (n, 2) int32
    stuck_at         where on them, as fractions of their length, (n, 2) float64
    pace             longest step that hair which passes through hair allows next [s]
    stretched        length over that at rest of a segment that was warned of; 1: none was
    """

    positions: np.ndarray
    velocities: np.ndarray
    accelerations: np.ndarray
    fresh: np.ndarray
    tensions: np.ndarray
    inverse_lengths: np.ndarray | None
    stuck: np.ndarray
    stuck_at: np.ndarray
    pace: float
    stretched: float
