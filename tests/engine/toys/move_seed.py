"""A value per frame that takes a turn."""

from typing import Annotated

from numeral import Numeral
from tally import numeral, tally

from hairpipe.engine import Time, node
from hairpipe.units import Ge, Metres


@node(frames="each")
def move_seed(
    seed: Numeral, time: Time, *, turn: int = 1000, step: Annotated[Metres, Ge(0)] = 1.0, still: bool = False
) -> Numeral:
    """Move a number along; from frame `turn` on twice as fast."""
    tally("move_seed", time.frame)
    return numeral(seed.value + (0 if still else step * time.frame * (2 if time.frame >= turn else 1)))
