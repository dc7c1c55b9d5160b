"""How a message names what is wrong: what was given, cut short, and the known name nearest to it."""

import difflib
from collections.abc import Sequence
from typing import Any

MOST_SHOWN = 60


def nearest(name: str, known: Sequence[str]) -> str:
    """Suggest the known name closest to a misspelt one, else all of them."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f"did you mean '{close[0]}'?"
    return "known: " + ", ".join(sorted(known)) if known else "there are none"


def brief(value: Any) -> str:
    """Write a value of a graph file, or the beginning of it."""
    try:
        return cut(repr(value) if isinstance(value, str) else str(value))
    except (ValueError, RecursionError):  # thousands of digits, or of groups in each other
        return "(too long to show)"


def cut(text: str) -> str:
    """Cut a text where it is long."""
    return text if len(text) <= MOST_SHOWN else text[:MOST_SHOWN] + "..."
