"""What locks leave to be simulated."""

from hairpipe.data import Groom, Strands, Table
from hairpipe.data.hair import HairState
from hairpipe.graph import Frames, Reached, Time, node


@node(frames="once")
def measure_locks(
    groom: Groom,
    hair: Frames[Strands],
    states: Frames[HairState],
    truth: Reached[Strands] | None,
    time: Time,
) -> Table:
    """At every frame, how long connections have lasted, how many hairs are simulated, and what the others are off by.

    Given the same hair without locks as `truth`, also how far points are from there.
    """
    from hairpipe.measure.locks import measure_locks as measure

    return measure(groom, hair, states, truth, time.fps)
