"""Numbers with units: 2mm, 0.5 %, 5s."""

import re
from typing import Literal, NamedTuple

from hairpipe.errors import BadInput

LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
TIMES = {"ms": 1e-3, "s": 1.0, "min": 60.0}
NUMBER = re.compile(r"\s*(\d{1,15}(?:\.\d{1,15})?(?:[eE][+-]?\d{1,2})?)\s*([a-zA-Z%]*)\s*")


class Tolerance(NamedTuple):
    """Largest error of tips and whole strands, root mean square: in metres, or in % of the length of a strand."""

    value: float
    unit: Literal["m", "%"]

    def __str__(self) -> str:
        return f"{self.value:g} %" if self.unit == "%" else f"{1e3 * self.value:g} mm"


def read_tolerance(text: str) -> Tolerance:
    """Read a length, or a share of the length of a strand in %; BadInput for another text, or a value not above 0."""
    number, unit = take_apart(text, (*LENGTHS, "%"), "--tolerance", "2mm, or 0.5% of the length of the hair")
    return Tolerance(number, "%") if unit == "%" else Tolerance(number * LENGTHS[unit], "m")


def read_seconds(text: str, where: str) -> float:
    """Read a time [s]; BadInput for another text, or a value not above 0."""
    number, unit = take_apart(text, tuple(TIMES), where, "5s, 300ms or 2min")
    return number * TIMES[unit]


def take_apart(text: str, units: tuple[str, ...], where: str, right: str) -> tuple[float, str]:
    """Split a text into a positive number and one of these units."""
    match = NUMBER.fullmatch(text)
    if not match or float(match[1]) <= 0.0:
        raise BadInput(f"'{text}' is not a positive number with a unit", where=where, right=right)
    if match[2] not in units:
        what = f"'{text}' has no unit" if not match[2] else f"'{match[2]}' is not a valid unit here"
        raise BadInput(what, where=where, right=right)
    return float(match[1]), match[2]
