"""Cost and error of locks."""

from hairpipe.engine import Frames, Reached, Time, node
from hairpipe.values import Groom, Strands, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_locks(
    groom: Groom,
    hair: Frames[Strands],
    states: Frames[HairState],
    truth: Reached[Strands] | None,
    time: Time,
) -> Table:
    """Measure ages of connections, simulated strands and errors of followers at every frame.

    With the same hair without locks as `truth`, the table has distances from it.
    """
    from hairpipe.measure.locks import measure_locks as measure

    return measure(groom, hair, states, truth, time.fps)
