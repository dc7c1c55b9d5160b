"""Roles of strands for the next frame: strands with large errors leave their locks, connections join others."""

import numpy as np

from hairpipe.data.locks import AUDITED, FOLLOWER, GUIDE, RELEASED, TRIED, LockState, Places
from hairpipe.sim.contact.hair.stiction import Connections
from hairpipe.sim.locks.auditing import about_roots, audited_locks, back_in, moved_since, to_audit
from hairpipe.sim.locks.following import Followed
from hairpipe.sim.locks.inheriting import inherited
from hairpipe.sim.locks.joining import guides_of, joined
from hairpipe.sim.locks.places import nearest_guides
from hairpipe.sim.settings import Locks


def regrouped(
    known: LockState,
    connections: Connections,
    ages: np.ndarray,
    found: Followed,
    offsets: np.ndarray,
    roots: np.ndarray,
    locks: Locks,
    closest: int,
) -> tuple[LockState, Connections]:
    """Return the state of locks after a frame, with the places before it, and the connections of guides; pure.

    known        state at its start
    connections  connections at its end; ages  their ages in frames, (n,) int32
    offsets      offsets of the strands, (S+1,) int32; roots  motions of their roots, (S, 3, 4)
    closest      maximum number of connections of a segment
    """
    strands = np.arange(len(known.guides), dtype=np.int32)
    ends = known.since + 1 >= locks.after
    audited = known.roles == AUDITED
    compared = known.compared & (not ends)
    loose = known.follows & (np.maximum(found.disagreement, found.pushed) > locks.tolerance)
    leaders = np.where(loose, strands, known.leaders)
    released = known.released | loose
    owners = np.searchsorted(offsets, connections.segments, side="right") - 1
    audit = None
    if ends and audited.any():
        audit, lock = audited_locks(known.guides[audited], found.errors[audited].astype(np.float32))
        good = audited.copy()
        good[audited] = (audit.errors <= locks.tolerance)[lock]
        released |= audited & ~good
        leaders[good] = leaders[known.guides[good]]
        # What the others stick to must last again before they follow again by that.
        ages = np.where((audited & ~good)[owners].any(axis=1), 0, ages).astype(np.int32)
    if ends:
        tried = (known.roles == TRIED) & (found.errors <= locks.tolerance)
        leaders, leading = back_in(leaders, *_find_nearest(known, tried, offsets), locks.most)
        released[leading] = False
    occupancy = np.where(audited & compared, leaders[known.guides], leaders)
    free = ~(compared | (leaders != strands))[owners].any(axis=1)
    ties = joined(leaders, occupancy, connections.segments[free], ages[free], offsets, locks)
    leaders = guides_of(ties, leaders, found.points, offsets)
    released &= np.bincount(leaders, minlength=len(leaders))[leaders] == 1
    guides = np.where(released | compared, leaders[known.guides], leaders)
    sample = np.zeros(len(strands), np.bool_)
    reference = known.reference
    if ends:
        here = about_roots(found.points, offsets, roots)
        moved, reference = moved_since(reference, here, offsets, locks.tolerance)
        sample = to_audit(leaders, locks.audit, known.turn + 1) & moved[leaders]
    roles = np.select(
        [compared, released, sample, leaders != strands],
        [known.roles, TRIED if ends else RELEASED, AUDITED, FOLLOWER],
        GUIDE,
    )
    leaders = np.where(sample, strands, leaders)
    connections, ages = inherited(connections, ages, leaders, offsets, closest)
    disagreement = found.disagreement[roles == FOLLOWER].astype(np.float32)
    turn = known.turn + ends
    since = 0 if ends else known.since + 1
    return LockState(
        roles, guides, ages, known.places, reference, disagreement, audit, turn=turn, since=since
    ), connections


def _find_nearest(known: LockState, chosen: np.ndarray, offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return strands on trial, (n,), of a mask, (S,) bool, and the guides near them, see `nearest_guides`."""
    among = np.flatnonzero(known.interpolated)
    rows = np.repeat(chosen[among], np.diff(offsets)[among])
    strands = np.flatnonzero(chosen)
    return strands, nearest_guides(strands, Places(*(values[rows] for values in known.places)), offsets)
