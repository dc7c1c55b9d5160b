"""The full state of a hair simulation between two frames."""

import numpy as np

from hairpipe.data.value import value


@value
class LockState:
    """Guides, which are simulated, and their followers (`sim/locks`).

    F rows: the points of strands that are interpolated (followers, audited and on trial), strand by strand.

    leaders       guide of each strand, itself for a guide, (strands,) int32
    ages          age of each connection in `HairState.stuck`, in frames, (n,) int32
    points        points of guides that each point of a follower follows, -1 if fewer than 4, (F, 4) int32
    offsets       offsets from those points, rotated back to rest [m], (F, 4, 3) float32
    bends         bends of followers when they began to follow, rotated back likewise [m], (F, 3) float32
    disagreement  disagreement of a follower's guides, 0 for simulated strands [m], (strands,) float32
    audited       previous guide of a strand that is audited or on trial, -1: none, (strands,) int32
    parted        previous guide of a strand that has left its lock, -1: none, (strands,) int32
    errors        rms error of a strand whose audit ended at this frame, else NaN [m], (strands,) float32
    turn          number of the current audit
    since         its duration so far, in frames
    """

    leaders: np.ndarray
    ages: np.ndarray
    points: np.ndarray
    offsets: np.ndarray
    bends: np.ndarray
    disagreement: np.ndarray
    audited: np.ndarray
    parted: np.ndarray
    errors: np.ndarray
    turn: int
    since: int


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
