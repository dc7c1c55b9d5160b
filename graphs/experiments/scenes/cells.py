"""What tuning found, in the cells of a table that has a row for every scene."""

from hairpipe.app.tune.measured import Chaos, Measured, Tolerance
from hairpipe.app.tune.report import length, millimetres, names_of
from hairpipe.app.tune.tuning import Tuned, saves


def left_out(tuned: Tuned) -> str:
    """Say what the choice leaves out, or why nothing was chosen."""
    parts = tuned.choice.parts
    reference = tuned.reference
    for check in tuned.checks:
        if not check.chosen.kept(tuned.tolerance.value):
            return f"nothing is promised: in a check {check.chosen.refused or 'the error is larger'}"
    if parts is not None:
        return "; ".join(names_of(parts)) or "nothing"
    if isinstance(reference, Chaos) and reference.floor > tuned.tolerance.value:
        below = f"nothing is promised below the floor of {length(reference.floor, tuned.tolerance)}"
        return "; ".join([below, *cheapest_at_first(tuned, reference)])
    why = tuned.full.refused or "with a larger error"
    return f"nothing is promised: the graph as it is, {why}"


def cheapest_at_first(tuned: Tuned, chaos: Chaos) -> list[str]:
    """Name the one simplification that saves most and keeps the tolerance for as long as hair can be predicted."""
    sound = {part: found for part, found in tuned.singles.items() if found.bound <= tuned.tolerance.value}
    saving = {part: found for part, found in sound.items() if saves(part, found, tuned.full)}
    if not saving:
        return []
    part = min(saving, key=lambda part: (saving[part].seconds, part.text))
    return [f"the first {chaos.seconds:.2f} s could do with {part.text}"]


def error(found: Measured, tolerance: Tolerance) -> str:
    """Write an error and its bound, in the unit of the tolerance, or in mm."""
    if found.fault:
        return "fails"
    numbers = (f"{value:.2g}" if tolerance.unit == "%" else millimetres(value) for value in (found.error, found.bound))
    return "{} ({})".format(*numbers)


def faster(tuned: Tuned) -> str:
    """Write how many times as fast the choice is as the graph as it is."""
    return "" if tuned.choice.parts is None else f"{tuned.full.seconds / tuned.choice.measured.seconds:.1f}"
