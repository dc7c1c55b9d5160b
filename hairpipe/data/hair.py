"""The full state of a hair simulation between two frames."""

import numpy as np

from hairpipe.data.locks import LockState
from hairpipe.data.value import value


@value
class Touching:
    """Contact of points with bodies at a frame, which the next one goes on with; only of points that touch.

    points    points of the groom, ascending, (n,) int32
    states    as of `sim/contact/body/implicit.py`, (n,) int8
    damping   tangential and normal damping [kg/s], (n, 2)
    slid      velocity of sliding to which the tangential damping belongs, where the damper would exceed mu N, else 0
              [m/s], (n, 3)
    normals   unit normals of the body, (n, 3)
    """

    points: np.ndarray
    states: np.ndarray
    damping: np.ndarray
    slid: np.ndarray
    normals: np.ndarray

    def renumbered(self, numbers: np.ndarray) -> "Touching":
        """Return the contacts under other numbers of points, (P,), without those of negative ones; pure."""
        points = numbers[self.points].astype(np.int32)
        known = points >= 0
        return Touching(points[known], self.states[known], self.damping[known], self.slid[known], self.normals[known])


@value
class Shear:
    """Tangential elongations of the contacts between strands at the end of a step.

    segments     pairs of segments of the groom in contact, first < second, in lexicographic order, (n, 2) int32
    elongations  way of the first point along the contact against the second, which friction opposes [m], (n, 3) float64
    """

    segments: np.ndarray
    elongations: np.ndarray

    def renumbered(self, numbers: np.ndarray) -> "Shear":
        """Return them under other, ascending numbers of points, (P,), without those of negative ones; pure."""
        segments = numbers[self.segments].astype(np.int32)
        known = (segments >= 0).all(axis=1)
        return Shear(segments[known], self.elongations[known])


@value
class HairState:
    """Everything the next frame needs, in the layout of the simulation: particles in rows, strands in the last axis.

    positions        in the world [m], (rows, 3, lanes) float64
    velocities       [m/s], same shape, float64, or float32 in single precision
    accelerations    accelerations of the last step [m/s^2], same shape and precision
    fresh            strands whose forces jumped afterwards: accelerations are invalid, (blocks, lanes) bool
    tensions         multipliers of the springs to the next particles [N], (rows, springs, lanes)
    inverse_lengths  1 / rest length of those springs [1/m], same shape; None if they rest in the groom's shape
    stuck            pairs of connected segments of the groom, first < second, (n, 2) int32
    stuck_at         positions of the connection on both, as fractions of their length, (n, 2) float64
    pace             longest next step that crossings allow [s]
    stretched        largest stretch of a segment that was reported; 1: none was
    locks            state of locks; None: every hair is simulated. Of followers only the axis is up to date
    touching         contact with bodies; None: there are none, or it is unknown
    shear            contact between strands; None: there is none, or it is unknown
    impulses         impulses of goals on strands in the last frame [N s], (strands, 3) float64, of followers 0; None:
                     there are no goals
    grown            size of the skin at the roots over that at the first frame
    grown_reported   the last such ratio that was reported; 1: none was
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
    locks: LockState | None = None
    touching: Touching | None = None
    shear: Shear | None = None
    impulses: np.ndarray | None = None
    grown: float = 1.0
    grown_reported: float = 1.0

    def leaders(self, strands: int) -> np.ndarray:
        """Return the strand by whose simulation each of so many moves, itself if it is simulated, (strands,) int32."""
        return np.arange(strands, dtype=np.int32) if self.locks is None else self.locks.leaders

    def simulated(self, strands: int) -> np.ndarray:
        """Return which of so many strands are simulated, the others being interpolated in locks, (strands,) bool."""
        return self.leaders(strands) == np.arange(strands)
