"""What users read: how a message names what is wrong, and the warnings of nodes."""

import difflib
import re
import unicodedata
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

MOST_SHOWN = 60
MOST_WARNINGS = 20
LONG_WORD, LONG_LINE = 300, 2000
"""Characters without a blank, and altogether, beyond which a message is cut; a path is rarely as long."""


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


def one_line(text: str) -> str:
    """Write a text on one line of a terminal, whatever is in it: what is not printed is escaped, what is long cut."""
    clean = text if text.isprintable() else "".join(c if is_printed(c) else escaped(c) for c in text)
    return shortened(re.sub(rf"\S{{{LONG_WORD + 1},}}", lambda word: shortened(word[0], LONG_WORD), clean), LONG_LINE)


def is_printed(character: str) -> bool:
    """Whether a terminal shows a character, and does nothing else with it."""
    return character.isprintable() or unicodedata.category(character) == "Zs"


def escaped(character: str) -> str:
    """Write a character as Python source would."""
    return character.encode("unicode_escape").decode()


def shortened(text: str, most: int) -> str:
    """Leave out the middle of a text that is long."""
    return text if len(text) <= most else f"{text[: most * 3 // 4]}...{text[-most // 5 :]}"


@contextmanager
def recorded_warnings() -> Iterator[list[str]]:
    """Record the warnings that are meant for the user, each once; they are in the list at the end."""
    texts: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield texts
    meant = [str(w.message) for w in caught if issubclass(w.category, UserWarning | RuntimeWarning)]
    texts += list(dict.fromkeys(meant))[:MOST_WARNINGS]
