"""What the frames of nodes cost."""

from typing import Annotated

from hairpipe.data import Table
from hairpipe.graph import Reached, Spent, node
from hairpipe.units import Ge


@node(frames="once")
def measure_cost(
    nodes: tuple[Reached[Spent], ...], *, warm: Annotated[int, Ge(1)] = 4, timed: Annotated[int, Ge(1)] = 12
) -> Table:
    """Processor seconds per frame of one or more nodes, as recorded when their results were computed.

    Any node with a value per frame can be measured, also a model of hair of your own: nothing is computed again. The
    seconds are those of all threads, so that threads that wait for each other count: for figures to be compared, run
    with `-j 1` on a machine that does nothing else, from an empty cache. A simulation that diverges is measured up to
    there. Results that were in the cache already keep the time that they took then, on the machine of then.

    nodes  whose times are added up, frame by frame
    warm   frames after the first that do not count, in which kernels are compiled and hair begins to move
    timed  frames after those that count
    """
    from hairpipe.measure.cost import cost_table

    seconds = [{frame: spent.processor for frame, spent in shot.items()} for shot in nodes]
    return cost_table(seconds, warm, timed)
