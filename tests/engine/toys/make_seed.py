"""A value for the shot."""

from pathlib import Path

from numeral import Bent, Numeral
from tally import numeral, tally

from hairpipe.engine import node


@node(frames="once")
def make_seed(*, value: float = 1.0, file: Path | None = None, bent: Bent | None = None) -> Numeral:
    """Make a number.

    value  of the number
    """
    tally("make_seed")
    return numeral(value + (len(file.read_bytes()) if file else 0) + (bent.strength if bent else 0))
