"""The state of a simulation between two frames: of hair and its locks, and of hair as loosely connected particles.

Particles: Bando, Chen, Nishita 2003.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.values.groom import Groom
from hairpipe.values.value import value

FOLLOWED = 4
"""Maximum number of guide points that a point follows, each on a guide of its own."""
GUIDE, FOLLOWER, AUDITED, RELEASED, TRIED = np.arange(5, dtype=np.uint8)
"""Roles of strands: a guide is simulated, a follower interpolated; an audited strand is both, to measure the error of
its lock; a released strand is simulated since it left its lock, and a tried one is both, to join a lock again."""


class Places(NamedTuple):
    """Guide points of interpolated strands; rows are the points of these, strand by strand.

    counts   number of guide points that a point follows, (F,) uint8
    points   the guide points, the nearest first; the first `counts` are valid, (F, FOLLOWED) int32
    offsets  offsets of the point from them, rotated back to the guide at rest [m], (F, FOLLOWED, 3) float32
    bends    twice the vector from the point to the middle of its two neighbours, at the tip to the previous point;
             rotated back like the first offset [m], (F, 3) float32
    """

    counts: np.ndarray
    points: np.ndarray
    offsets: np.ndarray
    bends: np.ndarray


def no_places(points: int) -> Places:
    """Give so many points nothing to follow."""
    followed = np.zeros((points, FOLLOWED), np.int32)
    offsets = np.zeros((points, FOLLOWED, 3), np.float32)
    return Places(np.zeros(points, np.uint8), followed, offsets, np.zeros((points, 3), np.float32))


@value
class Audit:
    """Locks whose audit ended at this frame, in the order of their guides.

    errors  rms error of the audited strands of a lock [m], (n,) float64
    hairs   number of these strands, (n,) int64
    """

    errors: np.ndarray
    hairs: np.ndarray


@value
class LockState:
    """Guides, which are simulated, and their followers (`shot/locks.py`).

    roles         role of each strand: GUIDE, FOLLOWER, AUDITED, RELEASED or TRIED, (strands,) uint8
    guides        guide of each strand: itself, the one it follows or is compared with, or if it has left its lock,
                  the previous one, (strands,) int32
    ages          age of each connection in `HairState.stuck`, in frames, (n,) int32
    places        what the points of strands that are interpolated or compared follow
    reference     points in the frames of their roots, from which displacement until an audit is measured [m], (P, 3)
                  float32
    disagreement  disagreement of the guides of each follower [m], (followers,) float32
    audit         the audit that ended at this frame; None: none did
    turn          number of the current audit
    since         its duration so far, in frames
    """

    roles: np.ndarray
    guides: np.ndarray
    ages: np.ndarray
    places: Places
    reference: np.ndarray
    disagreement: np.ndarray
    audit: Audit | None
    turn: int
    since: int

    @property
    def follows(self) -> np.ndarray:
        """The strands that are not simulated, (strands,) bool."""
        return self.roles == FOLLOWER

    @property
    def interpolated(self) -> np.ndarray:
        """The strands that have places: followers, and strands that are compared, (strands,) bool."""
        return self.follows | self.compared

    @property
    def compared(self) -> np.ndarray:
        """The strands that are simulated and interpolated, (strands,) bool."""
        return (self.roles == AUDITED) | (self.roles == TRIED)

    @property
    def released(self) -> np.ndarray:
        """The strands that have left their lock, and neither follow again nor have followers, (strands,) bool."""
        return (self.roles == RELEASED) | (self.roles == TRIED)

    @property
    def leaders(self) -> np.ndarray:
        """The strand by whose simulation each strand moves, itself if it is simulated, (strands,) int32."""
        return np.where(self.follows, self.guides, np.arange(len(self.guides), dtype=np.int32))


def no_locks(strands: int, stuck: int = 0, reference: np.ndarray | None = None) -> LockState:
    """Simulate every one of so many strands, of which so many connections have just been made.

    reference  as in `LockState`; None: of no points
    """
    roles = np.full(strands, GUIDE)
    guides = np.arange(strands, dtype=np.int32)
    ages = np.zeros(stuck, np.int32)
    reference = np.zeros((0, 3), np.float32) if reference is None else reference
    return LockState(roles, guides, ages, no_places(0), reference, np.zeros(0, np.float32), None, turn=0, since=0)


@value
class Touching:
    """Contact of points with bodies at a frame, which the next one goes on with; only of points that touch.

    points    points of the groom, ascending, (n,) int32
    states    as of `contact/body_implicit.py`, (n,) int8
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


@value
class Particles:
    """Particles that represent hair at rest, and the links between them; those below the skin come first.

    hair        strands on which the particles lie, at rest
    strands     strand of `hair` of each particle, (N,) int32
    arcs        arc length from the skin, along the axis of a curl; negative below the skin [m], (N,) float64
    points      [m], (N, 3) float64
    directions  directions of the hair towards the tip, unit vectors, (N, 3) float64
    masses      [kg], (N,) float64
    links       pairs of particles, the one nearer to the root first, (E, 2) int32
    alignments  a_ij of equation (6) at rest, (E,) float64
    reach       h_1: link strength is zero at twice this distance [m]
    range       h_2: hairs interact within twice this distance [m]
    """

    hair: Groom
    strands: np.ndarray
    arcs: np.ndarray
    points: np.ndarray
    directions: np.ndarray
    masses: np.ndarray
    links: np.ndarray
    alignments: np.ndarray
    reach: float
    range: float


@value
class Cloud:
    """Particles at one frame; order and count are those at rest.

    points      [m], (N, 3) float64
    velocities  [m/s], (N, 3) float32
    directions  of the hair there, unit vectors, (N, 3) float64
    """

    points: np.ndarray
    velocities: np.ndarray
    directions: np.ndarray


@value
class ParticleState:
    """Everything the next frame of particles needs.

    points      [m], (N, 3) float64
    velocities  [m/s], (N, 3) float64
    directions  unit vectors, (N, 3) float64
    tensions    of the links [N], (E,) float64
    """

    points: np.ndarray
    velocities: np.ndarray
    directions: np.ndarray
    tensions: np.ndarray
