"""Locks of hair between two frames: the role of each strand, and the guide points that interpolated strands follow."""

from typing import NamedTuple

import numpy as np

from hairpipe.data.value import value

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
    """Guides, which are simulated, and their followers (`sim/locks`).

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
