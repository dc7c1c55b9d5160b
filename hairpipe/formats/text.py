"""Text files with any line ends and a byte order mark; faults are reported in one sentence."""

import warnings
from pathlib import Path

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.plain_file import content

MOST_BYTES = 64 << 20
"""Largest size of a text file: parsed, it takes up to twenty times as much memory [bytes]."""
LARGEST = 1e12  # far above positions, angles and times; squares and products of such numbers are finite


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file, with lines that end in "\\n"; BadInput where it is another, empty or large."""
    try:
        text = content(path, "a text file", MOST_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise BadInput(f"byte {fault.start} is not UTF-8", where=path, right="a text file in UTF-8") from None
    if not text.strip():
        raise BadInput("the file is empty", where=path, right="a text file")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def parse_number(word: str) -> float | None:
    """Return the number in a word; None for another word, and for a number that is not finite or beyond LARGEST."""
    try:
        value = float(word)
    except ValueError:
        return None
    return value if abs(value) <= LARGEST else None


def parse_numbers(words: bytes, count: int, kind: type = np.float64) -> np.ndarray | None:
    """Return numbers between blanks, (count,), in memory of their size; None where there are others.

    kind  float64, of any number of digits and also not finite, or int64, the nearest one
    """
    if not count:
        return np.empty(0, kind) if not words.strip() else None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a word that is not a number, where numpy stops
            found = np.fromstring(words, kind, sep=" ")
    except ValueError:
        return None
    return found if len(found) == count else None
