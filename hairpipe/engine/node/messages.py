"""Parts of messages to users, and the warnings of nodes."""

import difflib
import re
import unicodedata
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

MOST_SHOWN = 60
MOST_NAMES = 12
"""Maximum number of known names in a message."""
MOST_WARNINGS = 20
LONG_WORD, LONG_LINE = 300, 2000
"""Maximum number of characters of a word, and of a message; few paths are as long."""


def nearest(name: str, known: Sequence[str]) -> str:
    """Suggest the known name closest to an unknown one, else list all."""
    close = closest(name, known)
    if close:
        return f"did you mean '{close}'?"
    return f"known: {listed(sorted(known))}" if known else "there are none"


def closest(name: str, known: Sequence[str]) -> str | None:
    """Find the known name closest to an unknown one; None if none is similar."""
    return next(iter(difflib.get_close_matches(name, known, n=1, cutoff=0.5)), None)


def listed(names: Sequence[str]) -> str:
    """List names; if there are many, only the first."""
    rest = f", ... {len(names)} in all" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + rest


def brief(value: Any) -> str:
    """Return the beginning of a value of a graph file as text."""
    try:
        return cut(repr(value) if isinstance(value, str) else str(value))
    except (ValueError, RecursionError):  # thousands of digits, or of groups in each other
        return "(too long to show)"


def cut(text: str) -> str:
    """Truncate a long text."""
    return text if len(text) <= MOST_SHOWN else text[:MOST_SHOWN] + "..."


def one_line(text: str) -> str:
    """Write a text on one line of a terminal: unprintable characters are escaped, long texts are shortened."""
    clean = (
        text
        if text.isprintable()
        else "".join(c if is_printed(c) else c.encode("unicode_escape").decode() for c in text)
    )
    return shortened(re.sub(rf"\S{{{LONG_WORD + 1},}}", lambda word: shortened(word[0], LONG_WORD), clean), LONG_LINE)


def is_printed(character: str) -> bool:
    """Whether a character is printable, not a control character."""
    return character.isprintable() or unicodedata.category(character) == "Zs"


def shortened(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most * 3 // 4]}...{text[-most // 5 :]}"


@contextmanager
def recorded_warnings() -> Iterator[list[str]]:
    """Record warnings for the user without duplicates; the list is filled at the end."""
    texts: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield texts
    relevant = [str(w.message) for w in caught if issubclass(w.category, UserWarning | RuntimeWarning)]
    texts += list(dict.fromkeys(relevant))[:MOST_WARNINGS]
