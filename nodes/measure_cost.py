"""Processor time of the frames of nodes."""

from typing import Annotated

from hairpipe.engine import Reached, Spent, node
from hairpipe.units import Ge
from hairpipe.values import Table


@node(frames="once")
def measure_cost(
    nodes: tuple[Reached[Spent], ...], *, warm: Annotated[int, Ge(1)] = 4, timed: Annotated[int, Ge(1)] = 12
) -> Table:
    """Tabulate the recorded processor time per frame of one or more nodes.

    Any node with a value per frame is valid, also a new model of hair: nothing is computed again. Times are sums over
    all threads, including waiting threads: for comparable figures, run with `-j 1` on an idle machine, from an empty
    cache. A diverging simulation counts up to its last frame. Cached results keep the times of their own run and
    machine.

    nodes  simulations whose times are added up, frame by frame
    warm   number of excluded frames after the first, for compilation and start of motion
    timed  number of included frames after those
    """
    from hairpipe.measure.motion import cost_table

    seconds = [{frame: spent.processor for frame, spent in shot.items()} for shot in nodes]
    return cost_table(seconds, warm, timed)
