"""A fold over frames."""

import warnings
from typing import NamedTuple

import numpy as np
from numeral import Numeral, Sum
from tally import numeral, tally

from hairpipe.engine import Time, node


class Added(NamedTuple):
    """The number to look at, and the state to go on from."""

    number: Numeral
    state: Sum


@node(frames="scan")
def add_up(number: Numeral, previous: Sum | None, time: Time, *, warn: int = 0) -> Added:
    """Add numbers up over time."""
    tally("add_up", time.frame)
    if time.frame == warn:
        warnings.warn("a strand is too short", stacklevel=1)
    total = number.value + (0.9 * previous.total if previous else 0.0)
    history = np.append(previous.history if previous else np.zeros(0), total)
    return Added(numeral(total), Sum(total, history))
