"""A value per frame from this frame and the one before."""

from numeral import Numeral
from tally import numeral, tally

from hairpipe.engine import Pair, node


@node(frames="each")
def soften(number: Pair[Numeral], other: Numeral | None = None) -> Numeral:
    """Average over two frames."""
    tally("soften")
    return numeral((number.previous.value + number.current.value) / 2 + (other.value if other else 0))
