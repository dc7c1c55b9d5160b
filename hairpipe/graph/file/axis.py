"""Values along an axis of a wedge: a list, an evenly spaced range, or random numbers from a seed."""

import random
from collections.abc import Mapping
from typing import Any, TypeGuard

from hairpipe.errors import BadInput
from hairpipe.graph.node.messages import brief

MOST_VALUES = 1000
LIST, RANGE = "a list of values", "{ from = 0.1, to = 1.0, count = 4 }, with log = true in equal ratios"
RANDOM = "{ random = { from = 0.1, to = 1.0, count = 4 }, seed = 1 }"
DIGITS, RANDOM_DIGITS = 12, 6
"""Significant digits of the numbers of a range, and of random numbers."""


def read_axis(name: str, given: Any) -> tuple[Any, ...]:
    """Read the values of one setting; BadInput if there are no values, or one occurs twice.

    name  of the setting; it is part of the seed, so axes of the same seed are independent
    """
    values = values_of(name, given)
    if not values:
        raise BadInput("no values", right=LIST)
    twice = next((value for place, value in enumerate(values) if value in values[:place]), None)
    if twice is not None:
        raise BadInput(f"{brief(twice)} occurs twice", right="every value once")
    return values


def values_of(name: str, given: Any) -> tuple[Any, ...]:
    """Return the values of a list, or those of a range."""
    if isinstance(given, list):
        return tuple(given)
    if isinstance(given, dict) and "random" in given:
        seed = given.get("seed")
        span = given["random"]
        if given.keys() != {"random", "seed"} or type(seed) is not int or not isinstance(span, dict):
            raise BadInput(brief(given), right=RANDOM)
        start, end, count, log = read_span(span, RANDOM)
        draw = random.Random(f"{seed} {name}")
        return tuple(rounded(between(start, end, draw.random(), log=log), RANDOM_DIGITS) for _ in range(count))
    if not isinstance(given, dict):
        raise BadInput(f"{brief(given)} is not an axis", right=f"{LIST}, or {RANGE}")
    start, end, count, log = read_span(given, RANGE)
    numbers = [rounded(between(start, end, k / max(1, count - 1), log=log), DIGITS) for k in range(count)]
    whole = isinstance(start, int) and isinstance(end, int) and all(number.is_integer() for number in numbers)
    return tuple(map(int, numbers) if whole else numbers)


def read_span(given: Mapping[str, Any], right: str) -> tuple[float, float, int, bool]:
    """Read the ends of a range, the number of its values, and whether their ratios are equal."""
    start = given.get("from")
    end = given.get("to")
    count = given.get("count")
    log = given.get("log", False)
    known = given.keys() <= {"from", "to", "count", "log"} and isinstance(log, bool)
    if not known or not is_number(start) or not is_number(end) or type(count) is not int:
        raise BadInput(brief(given), right=right)
    if not 1 <= count <= MOST_VALUES:
        raise BadInput(f"count = {count}", right=f"1 to {MOST_VALUES}")
    if log and not min(start, end) > 0.0:
        raise BadInput(f"log = true from {start} to {end}", right="numbers above 0")
    return start, end, count, log


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value of TOML is a finite number."""
    return type(value) in (int, float) and abs(value) < 1e300


def between(start: float, end: float, share: float, *, log: bool) -> float:
    """Interpolate between two numbers, linearly or on a logarithmic scale."""
    return start * (end / start) ** share if log else start + share * (end - start)


def rounded(value: float, digits: int) -> float:
    """Round to significant digits."""
    return float(f"{value:.{digits}g}")
