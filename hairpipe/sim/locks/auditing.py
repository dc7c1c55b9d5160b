"""The audit: some locks, in turn, are simulated in full, and compared with interpolated followers.

It is in the run, so that what is audited feels what guides feel. It lasts as many frames as a connection must, and
comes to each lock every `1 / audit` times; hairs of a lock whose error is too large at its end part. What it does
not see is the errors of guides themselves: a guide of many strands touches other guides otherwise than many
hairs would.

Hair that has parted is on trial likewise, next to the nearest guides, from one audit to the next: hair by hair, it
follows again where it is within the tolerance at the end, in the lock of the nearest that has room; or when its
connections have lasted again. Where there is no room, some are guides from then on, to which others on trial are
assigned. A trial says nothing of those that follow.
"""

import numpy as np
from numba import njit


def to_audit(leaders: np.ndarray, share: float, turn: int) -> np.ndarray:
    """Return the guide that each hair follows which is audited in a turn, -1 for the others, (S,) int32; pure.

    leaders  of every strand, (S,) int32; share  of the locks; of eight and more two at least, for a bound
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
    """Return the root mean square of the errors of the audited hairs of each lock, and of how many, (n,) each; pure.

    guides  of every strand, -1 where it is not audited, (S,) int32; errors  of strands [m], (S,)

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
    """Return the guide of every strand after trials, (S,) int32, and strands that shall lead others, ascending; pure.

    leaders    of every strand before, (S,) int32
    beside     guides of those on trial, the nearest first, -1: no more, of the others -1, (S, n)
    errors     of strands [m], (S,)
    tolerance  up to which a hair follows again [m], by the numbers of strands while a lock has at most so many hairs

    Of those for which there is no room, one in `most` shall lead.
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
