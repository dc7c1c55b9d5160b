"""The take of a clip that holds an instant: from cut to cut, or to an end of the clip. No motion goes on beyond it.

All times are in samples of the clip.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from hairpipe.errors import BadInput

SLACK = 0.1  # by which an instant may be off its sample: files round their frame time, and shots are long


class Take(NamedTuple):
    """Samples of a clip between which a body moves without a jump.

    first, last    of the samples, both included
    opens, closes  whether a cut is before the first, after the last; else the clip ends there
    """

    first: int
    last: int
    opens: bool
    closes: bool

    def window(self, at: float) -> tuple[tuple[float, float, float], float]:
        """Return three instants, of which the middle one is posed and the others give its rates, and their distance.

        The distance is 1, half to either side, less at an end of the take: rates are one-sided there. It is 0 where
        the body holds still: outside the clip. Up to a cut, no sample of the take may be left: motion goes on there as
        between its last two.
        """
        low = min(self.first, at) if self.opens else float(self.first)
        high = max(self.last, at) if self.closes else float(self.last)
        now = min(max(at, low), high)
        if abs(at - now) > SLACK or low == high:
            return (now, now, now), 0.0
        early = at - 0.5
        late = at + 0.5
        span = 1.0 - max(low - early, 0.0) - max(late - high, 0.0)
        return (max(early, low), now, min(late, high)), span


def take_at(count: int, at: float, cuts: Sequence[tuple[float, float]]) -> Take:
    """Return the take of a clip that holds an instant; pure.

    count  of samples
    cuts   the last instant of the shot before each cut, and the first after it, ascending

    Which of the samples between the two are before the cut is not known: none of them is used. Raises BadInput where a
    take has no sample.
    """
    starts = [math.ceil(after - SLACK) for _, after in cuts if after <= at]
    ends = [math.floor(before + SLACK) for before, after in cuts if after > at]
    first = max((start for start in starts if 0 < start < count), default=0)
    last = min((end for end in ends if 0 <= end < count - 1), default=count - 1)
    if first > last:
        what = f"the clip has no sample between the two cuts around its sample {at:.1f}"
        raise BadInput(what, where="cuts", right="one sample or more between two cuts")
    return Take(first, last, first > 0, last < count - 1)
