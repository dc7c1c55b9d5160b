"""Who leads and who follows from now on: locks part where they are off, connections join others, audits go on."""

from typing import NamedTuple

import numpy as np

from hairpipe.data.hair import LockState
from hairpipe.sim.contact.hair.stiction import Connections
from hairpipe.sim.locks.auditing import back_in, passed, to_audit
from hairpipe.sim.locks.inheriting import inherited
from hairpipe.sim.locks.joining import guides_of, joined
from hairpipe.sim.settings import Locks


class Deviations(NamedTuple):
    """Deviations of interpolated hairs, rms over the points of each [m], (S,).

    disagreement  disagreement of the guides
    pushed        displacement by bodies
    off           error of hairs that are audited or on trial, against their own simulation
    beside        guides near hairs on trial, the nearest first, -1: no more, (S, FOLLOWED) int32
    """

    disagreement: np.ndarray
    pushed: np.ndarray
    off: np.ndarray
    beside: np.ndarray


class Grouping(NamedTuple):
    """Guides, followers, audited and parted strands, as the fields of the same names of `LockState`.

    connections  connections of simulated strands; ages  age of each in frames, (n,) int32
    """

    leaders: np.ndarray
    connections: Connections
    ages: np.ndarray
    audited: np.ndarray
    parted: np.ndarray
    errors: np.ndarray
    turn: int
    since: int


def follows(leaders: np.ndarray) -> np.ndarray:
    """Tell which hairs are not simulated, (S,) bool."""
    return leaders != np.arange(len(leaders))


def is_carried(leaders: np.ndarray, audited: np.ndarray) -> np.ndarray:
    """Find which hairs are interpolated, (S,) bool: followers, and compared ones."""
    return follows(leaders) | (audited >= 0)


def grouped(
    known: LockState,
    connections: Connections,
    ages: np.ndarray,
    deviations: Deviations,
    places: tuple[np.ndarray, np.ndarray],
    locks: Locks,
    closest: int,
) -> Grouping:
    """Return guides and followers after a frame; pure.

    known        grouping at its start
    connections  connections at its end; ages  their ages in frames, (n,) int32
    places       all points [m], (P, 3), and the offsets of the strands, (S+1,) int32
    closest      maximum number of connections of a segment
    """
    points, offsets = places
    strands = np.arange(len(known.leaders), dtype=np.int32)
    compared = known.audited >= 0
    ends = known.since + 1 >= locks.after
    audited = compared & (known.parted < 0)
    loose = follows(known.leaders) & (np.maximum(deviations.disagreement, deviations.pushed) > locks.tolerance)
    leaders = np.where(loose, strands, known.leaders)
    parted = np.where(loose, known.leaders, known.parted)
    owners = np.searchsorted(offsets, connections.segments, side="right") - 1
    if ends:
        good = passed(np.where(audited, known.audited, -1), deviations.off, locks.tolerance)
        parted = np.where(audited & ~good, known.audited, parted)
        leaders[good] = leaders[known.audited[good]]
        # What the others stick to must last again before they follow again by that.
        ages = np.where((audited & ~good)[owners].any(axis=1), 0, ages).astype(np.int32)
        leaders, leading = back_in(leaders, deviations.beside, deviations.off, locks.tolerance, locks.most)
        parted[leading] = -1
    occupancy = np.where(audited & ~ends, leaders[known.audited], leaders)
    free = ~((compared & ~ends) | follows(leaders))[owners].any(axis=1)
    ties = joined(leaders, occupancy, connections.segments[free], ages[free], offsets, locks)
    leaders = guides_of(ties, leaders, points, offsets)
    alone = np.bincount(leaders, minlength=len(leaders))[leaders] == 1
    parted = np.where(alone & (parted >= 0), leaders[parted], -1).astype(np.int32)
    if ends:
        sample = to_audit(leaders, locks.audit, known.turn + 1)
        leaders = np.where(sample >= 0, strands, leaders)
        now = np.where(parted >= 0, parted, sample)
    else:
        now = np.where(compared, leaders[known.audited], -1)
    connections, ages = inherited(connections, ages, leaders, offsets, closest)
    errors = np.where(audited & ends, deviations.off, np.nan).astype(np.float32)
    now = now.astype(np.int32)
    turn = known.turn + ends
    since = 0 if ends else known.since + 1
    return Grouping(leaders, connections, ages, now, parted, errors, turn, since)
