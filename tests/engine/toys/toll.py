"""The time that nodes took."""

from numeral import Numeral
from tally import numeral, tally

from hairpipe.engine import Frames, Spent, node


@node(frames="once")
def toll(nodes: tuple[Frames[Spent], ...]) -> Numeral:
    """Add up what all frames of nodes took."""
    tally("toll")
    return numeral(sum(spent.processor for shot in nodes for spent in shot.values()))
