"""Hair that has parted from its lock, frame by frame: along how much of it, from the root on, it could follow still."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.data.hair import LockState
from hairpipe.groom.keys.key_turns import turns_since
from hairpipe.groom.strand_arrays import points_of_strands
from hairpipe.sim.boundary import motion_of_roots
from hairpipe.sim.locks.carrying import GuideMotion, carried
from hairpipe.sim.locks.grouping import is_carried
from hairpipe.sim.locks.places import Places, no_places

OFF = 4e-3
"""Distance [m] that counts as off here, rms over the points from the root on."""


class Parted(NamedTuple):
    """Hairs that have followed and are simulated for themselves now, who neither lead nor are audited.

    hairs   in the order in which they parted, (n,)
    places  what they followed, point by point, hair after hair
    shares  of their length, from the root on, that what they followed would have carried well at all frames since, (n,)
    """

    hairs: np.ndarray
    places: Places
    shares: np.ndarray


NOBODY = Parted(np.zeros(0, np.int64), no_places(0), np.zeros(0))
"""Has parted yet."""


def parted_at(parted: Parted, before: LockState, now: LockState, hair: Strands, groom: Groom, body: Mesh) -> Parted:
    """Return who has parted at a frame, of who had at the frame before; pure.

    before, now  of both frames; hair, body  at this one
    """
    counts = np.diff(groom.offsets)
    alone = (np.bincount(now.leaders, minlength=len(counts)) == 1) & (now.audited < 0)
    carried_before = np.flatnonzero(is_carried(before.leaders, before.audited))
    stay, part = alone[parted.hairs], alone[carried_before]
    hairs = np.concatenate([parted.hairs[stay], carried_before[part]])
    theirs, rows = np.repeat(stay, counts[parted.hairs]), np.repeat(part, counts[carried_before])
    known = before.points, before.offsets, before.bends
    places = Places(*(np.concatenate([a[theirs], b[rows]]) for a, b in zip(parted.places, known, strict=True)))
    shares = np.concatenate([parted.shares[stay], np.ones(np.count_nonzero(part))])
    return Parted(hairs, places, np.minimum(shares, _near(hairs, places, hair, groom, body))) if len(hairs) else NOBODY


def _near(hairs: np.ndarray, places: Places, hair: Strands, groom: Groom, body: Mesh) -> np.ndarray:
    """Return the shares of the length of hairs, from the root on, that places would carry to where they are, (n,)."""
    roots, offsets = motion_of_roots(body, groom), groom.offsets
    turns = turns_since(groom.points, hair, *roots)
    motion = GuideMotion(hair.points, hair.velocities.astype(np.float64), turns.turns, turns.spins)
    points, _, _ = carried(hairs, places, motion, offsets, groom.points, roots)
    squares = ((points - hair.points[points_of_strands(hairs, offsets)]) ** 2).sum(axis=1)
    counts = np.diff(offsets)[hairs]
    firsts = np.cumsum(counts) - counts
    along = np.arange(len(squares)) - np.repeat(firsts, counts)
    sums = np.cumsum(squares)
    means = (sums - np.repeat(sums[firsts] - squares[firsts], counts)) / (along + 1)
    return np.maximum.reduceat(np.where(means <= OFF**2, along, 0), firsts) / (counts - 1)
