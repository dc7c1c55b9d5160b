"""The audit: some locks, in turn, are simulated in full, and compared with interpolated followers.

It is part of the run, so audited hairs have the same surroundings as guides. It lasts as many frames as a connection
must, and selects each lock once in `1 / audit` audits; a lock whose error is too large at its end is dissolved. The
audit does not measure the errors of guides themselves: a guide of many strands has other contacts with guides than
many hairs would.

Hairs of dissolved locks are on trial likewise, compared with the nearest guides, from one audit to the next. A hair
whose error is within the tolerance at the end joins the lock of the nearest guide with free capacity; so does a hair
whose connections have lasted again. Without free capacity, some become guides, to which others on trial are assigned.
A trial does not measure the errors of followers.
"""

import numpy as np
from numba import njit


def to_audit(leaders: np.ndarray, share: float, turn: int) -> np.ndarray:
    """Return the guide of each hair that is audited in a turn, -1 for the others, (S,) int32; pure.

    leaders  guide of every strand, (S,) int32; share  share of the locks; at least two of eight or more, for a bound
    """
    follows = leaders != np.arange(len(leaders))
    chosen = np.full(len(leaders), -1, np.int32)
    if share > 0.0 and follows.any():
        guides = np.unique(leaders[follows])
        period = min(round(1.0 / share), max(len(guides) // 2, 4))
        among = follows & np.isin(leaders, guides[turn % period :: period])
        chosen[among] = leaders[among]
    return chosen


def means_of_locks(guides: np.ndarray, errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rms error of the audited hairs of each lock, and their number, (n,) each; pure.

    guides  guide of every strand, -1 if it is not audited, (S,) int32; errors  errors of strands [m], (S,)

    In the order of the guides.
    """
    among = guides >= 0
    _, locks, hairs = np.unique(guides[among], return_inverse=True, return_counts=True)
    squares = np.bincount(locks, errors[among].astype(float) ** 2, len(hairs))
    return np.sqrt(squares / hairs), hairs


def passed(guides: np.ndarray, errors: np.ndarray, tolerance: float) -> np.ndarray:
    """Find which audited hairs may follow again, (S,) bool: of locks with errors of at most a tolerance [m]; pure.

    guides, errors  as for `means_of_locks`
    """
    among = guides >= 0
    _, locks = np.unique(guides[among], return_inverse=True)
    good = np.zeros(len(guides), np.bool_)
    good[among] = (means_of_locks(guides, errors)[0] <= tolerance)[locks]
    return good


def back_in(
    leaders: np.ndarray, beside: np.ndarray, errors: np.ndarray, tolerance: float, most: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the guide of every strand after trials, (S,) int32, and the strands that become guides, ascending; pure.

    leaders    previous guide of every strand, (S,) int32
    beside     guides near a strand on trial, the nearest first, -1: no more; -1 for the others, (S, n)
    errors     errors of strands [m], (S,)
    tolerance  largest error of a hair that follows again [m]; strands join in ascending order while a lock has capacity

    One in `most` of the strands without a lock becomes a guide.
    """
    tried = (beside[:, 0] >= 0) & (errors <= tolerance)
    out = leaders.copy()
    sizes = np.bincount(leaders, minlength=len(leaders))
    _seat(np.flatnonzero(tried), beside, sizes, most, out)
    return out, np.flatnonzero(tried & (out == leaders))[::most]


@njit(cache=True)
def _seat(hairs, beside, sizes, most, leaders):
    """Give hairs the first guide that has room, one after the other, in place."""
    for s in hairs:  # One after another, by number: each takes room from those after it.
        for guide in beside[s]:
            if guide >= 0 and sizes[guide] < most:
                leaders[s] = guide
                sizes[guide] += 1
                break
