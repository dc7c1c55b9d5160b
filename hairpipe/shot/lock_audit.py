"""The audit: some locks, in turn, are simulated in full, and compared with interpolated followers.

It is part of the run, so audited hairs have the same surroundings as guides. It lasts as many frames as a connection
must, and selects each lock once in `1 / audit` audits; a lock whose error is too large at its end is dissolved. The
audit does not measure the errors of guides themselves: a guide of many strands has other contacts with guides than
many hairs would.

A lock is audited only if its guide has moved, in the frame of its root, by more than the tolerance since the end of the
last audit at which it had. An audited hair has another equilibrium than its interpolation, and disturbs its
neighbours, so hair at rest would never stay at rest; and if guides do not move, the error does not grow.
"""

import numpy as np
from numba import njit

from hairpipe.shot.lock_followers import distances
from hairpipe.values.hair import Audit


def to_audit(leaders: np.ndarray, share: float, turn: int) -> np.ndarray:
    """Return which followers are audited in a turn, (S,) bool; pure.

    leaders  guide of every strand, (S,) int32; share  share of the locks; at least two of eight or more, for a bound
    """
    follows = leaders != np.arange(len(leaders))
    if share == 0.0 or not follows.any():
        return np.zeros(len(leaders), np.bool_)
    guides = np.unique(leaders[follows])
    period = min(round(1.0 / share), max(len(guides) // 2, 4))
    return follows & np.isin(leaders, guides[turn % period :: period])


def about_roots(points: np.ndarray, offsets: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """Return points in the frames of their roots, (P, 3) float32 [m]; motions  x -> R x + t, (S, 3, 4); pure."""
    counts = np.diff(offsets)
    turns = np.repeat(motions[:, :, :3], counts, axis=0)
    return np.einsum("pij,pi->pj", turns, points - np.repeat(motions[:, :, 3], counts, axis=0)).astype(np.float32)


def moved_since(
    reference: np.ndarray, here: np.ndarray, offsets: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the strands that have moved by more than a tolerance [m], rms, (S,) bool; they get a new reference; pure.

    reference, here  earlier and present points in the frames of their roots [m], (P, 3) float32
    """
    moved = distances(here, reference, offsets) > tolerance
    return moved, np.where(np.repeat(moved, np.diff(offsets))[:, None], here, reference)


def audited_locks(guides: np.ndarray, errors: np.ndarray) -> tuple[Audit, np.ndarray]:
    """Return the errors of audited locks, and the lock of each strand among these, (A,); pure.

    guides  guides of the audited strands, (A,) int32; errors  rms errors of these strands [m], (A,)
    """
    _, locks, hairs = np.unique(guides, return_inverse=True, return_counts=True)
    squares = np.bincount(locks, errors.astype(float) ** 2, len(hairs))
    return Audit(np.sqrt(squares / hairs), hairs), locks


def back_in(leaders: np.ndarray, tried: np.ndarray, nearest: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the guide of every strand after trials, (S,) int32, and the strands that become guides, ascending; pure.

    leaders  previous guide of every strand, (S,) int32
    tried    strands whose trial has succeeded, ascending, (n,): they join in this order while a lock has capacity
    nearest  guides near each of them, the nearest first, then the strand itself, (n, FOLLOWED)

    One in `most` of the strands without a lock becomes a guide.
    """
    near = nearest[:, 0] != tried
    tried, nearest = tried[near], nearest[near]
    out = leaders.copy()
    _seat(tried, nearest, np.bincount(leaders, minlength=len(leaders)), most, out)
    return out, tried[out[tried] == tried][::most]


@njit(cache=True)
def _seat(hairs, nearest, sizes, most, leaders):
    """Give hairs the first guide that has room, one after the other, in place."""
    for i in range(len(hairs)):  # One after another, by number: each takes room from those after it.
        for guide in nearest[i]:
            if guide != hairs[i] and sizes[guide] < most:
                leaders[hairs[i]] = guide
                sizes[guide] += 1
                break
