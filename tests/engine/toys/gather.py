"""One value of any number of others."""

from numeral import Numeral
from tally import numeral, tally

from hairpipe.engine import Frames, node


@node(frames="once")
def gather(numbers: tuple[Numeral, ...], shots: tuple[Frames[Numeral], ...] | None = None) -> Numeral:
    """Write numbers behind each other, then the sum over all frames of the others."""
    tally("gather")
    later = sum(number.value for shot in shots or () for number in shot.values())
    return numeral(sum(number.value * 10.0**place for place, number in enumerate(reversed(numbers))) + later)
