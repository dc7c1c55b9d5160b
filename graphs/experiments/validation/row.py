"""A row of a validation: the error of one case, what is allowed, and the verdict."""

from typing import Literal, NamedTuple

Verdict = Literal["held", "missed", "not promised"]


class Row(NamedTuple):
    """The error of a case; a table of the fields is what a node of a validation computes.

    row       compared quantity
    case      model and resolution
    measured  largest magnitude of the error; NaN where it cannot be measured
    allowed   largest allowed magnitude
    unit      of both
    verdict   missed: the error is beyond the allowed one, which is promised
    source    independent truth
    """

    row: str
    case: str
    measured: float
    allowed: float
    unit: str
    verdict: Verdict
    source: str


def verdict_of(measured: float, allowed: float, *, promised: bool) -> Verdict:
    """Judge an error; one that is NaN is beyond every allowed one."""
    if not promised:
        return "not promised"
    return "held" if measured <= allowed else "missed"
