"""What tuning found, in the cells of a table that has a row for every scene."""

from hairpipe.tune.chaos import Chaos
from hairpipe.tune.measured import Measured
from hairpipe.tune.quantity import Tolerance
from hairpipe.tune.report import length, millimetres, names_of
from hairpipe.tune.tuning import Tuned


def left_out(tuned: Tuned) -> str:
    """Say what the choice leaves out, or why nothing was chosen."""
    parts, reference = tuned.choice.parts, tuned.reference
    if parts is not None:
        return "; ".join(names_of(parts)) or "nothing"
    if isinstance(reference, Chaos) and reference.floor > tuned.tolerance.value:
        return f"nothing is promised below the floor of {length(reference.floor, tuned.tolerance)}"
    why = tuned.full.refused or "off by more"
    return f"nothing is promised: the graph as it is, {why}"


def error(found: Measured, tolerance: Tolerance) -> str:
    """Write an error and its bound, in the unit of the tolerance, or in mm."""
    if found.fault:
        return "fails"
    numbers = (f"{value:.2g}" if tolerance.unit == "%" else millimetres(value) for value in (found.error, found.bound))
    return "{} ({})".format(*numbers)


def faster(tuned: Tuned) -> str:
    """Write how many times as fast the choice is as the graph as it is."""
    return "" if tuned.choice.parts is None else f"{tuned.full.seconds / tuned.choice.measured.seconds:.1f}"
