"""The full state of a hair simulation between two frames."""

import numpy as np

from hairpipe.data.value import value


@value
class LockState:
    """Which hairs are simulated, and what the others follow (`sim/locks`).

    Rows F are the points of those that are carried, since they follow, are audited or on trial, strand by strand.

    leaders       strand that is simulated for each, itself where it is, (strands,) int32
    ages          frames that each of `HairState.stuck` has lasted, (n,) int32
    points        of the groom that each point of a follower follows, -1 where no more, (F, 4) int32
    offsets       from there, turned back to where hair was at rest [m], (F, 4, 3) float32
    bends         of followers when they began to follow, turned back likewise [m], (F, 3) float32
    disagreement  of what a follower follows, 0 for what is simulated [m], (strands,) float32
    audited       guide that each followed which is audited or on trial now, -1: none, (strands,) int32
    parted        guide that each followed which is simulated by itself now, -1: none, (strands,) int32
    errors        of those whose audit ended at this frame, rms over their points, else NaN [m], (strands,) float32
    turn          number of the audit that goes on
    since         frames for which it has gone on
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
    locks            of hair that is simulated once; None: every hair is. Of followers the axis alone is up to date
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
