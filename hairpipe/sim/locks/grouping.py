"""Who leads and who follows from now on: locks part where they are off, connections join others, audits go on."""

from typing import NamedTuple

import numpy as np

from hairpipe.data.hair import LockState
from hairpipe.sim.contact.hair.stiction import Connections
from hairpipe.sim.locks.auditing import passed, to_audit
from hairpipe.sim.locks.inheriting import inherited
from hairpipe.sim.locks.joining import guides_of, joined
from hairpipe.sim.settings import Locks


class Deviations(NamedTuple):
    """What is known of hairs that guides carry, rms over the points of each [m], (S,).

    disagreement  of the guides
    pushed        by bodies
    off           from where they are themselves, of those that are audited
    """

    disagreement: np.ndarray
    pushed: np.ndarray
    off: np.ndarray


class Grouping(NamedTuple):
    """Who leads, follows and is audited; as the fields of the same names of `LockState`.

    connections  of those that are simulated; ages  frames that each has lasted, (n,) int32
    """

    leaders: np.ndarray
    connections: Connections
    ages: np.ndarray
    audited: np.ndarray
    errors: np.ndarray
    turn: int
    since: int


def follows(leaders: np.ndarray) -> np.ndarray:
    """Tell which hairs are not simulated, (S,) bool."""
    return leaders != np.arange(len(leaders))


def is_carried(leaders: np.ndarray, audited: np.ndarray) -> np.ndarray:
    """Tell which hairs guides carry: those that follow, and beside where they are those that are audited, (S,) bool."""
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
    """Return who leads and follows after a frame; pure.

    known        at its beginning
    connections  at its end; ages  frames that they have lasted, (n,) int32
    places       where all points are [m], (P, 3), and the offsets of the strands, (S+1,) int32
    closest      connections that a segment may have
    """
    (points, offsets), checked = places, known.audited >= 0
    loose = follows(known.leaders) & (np.maximum(deviations.disagreement, deviations.pushed) > locks.tolerance)
    leaders = np.where(loose, np.arange(len(loose)), known.leaders).astype(np.int32)
    owners = np.searchsorted(offsets, connections.segments, side="right") - 1
    theirs = checked[owners].any(axis=1)
    ends = known.since + 1 >= locks.after
    if ends:
        good = passed(known.audited, deviations.off, locks.tolerance)
        leaders[good] = leaders[known.audited[good]]
        # What the others stick to must last anew before they follow again.
        ages = np.where((checked & ~good)[owners].any(axis=1), 0, ages).astype(np.int32)
    ties = joined(leaders, connections.segments[~theirs], ages[~theirs], offsets, locks)
    leaders = guides_of(ties, leaders, points, offsets)
    if ends:
        now = to_audit(leaders, locks.audit, known.turn + 1)
        leaders = np.where(now >= 0, np.arange(len(now)), leaders).astype(np.int32)
    else:
        now = np.where(checked, leaders[known.audited], np.int32(-1))
    connections, ages = inherited(connections, ages, leaders, offsets, closest)
    errors = np.where(checked & ends, deviations.off, np.nan).astype(np.float32)
    return Grouping(leaders, connections, ages, now, errors, known.turn + ends, 0 if ends else known.since + 1)
