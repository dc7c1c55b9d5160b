"""What locks leave to be simulated."""

from hairpipe.data import Groom, Mesh, Strands, Table
from hairpipe.data.hair import HairState
from hairpipe.graph import Frames, Reached, Time, node


@node(frames="once")
def measure_locks(
    groom: Groom,
    hair: Frames[Strands],
    states: Frames[HairState],
    truth: Reached[Strands] | None,
    body: Frames[Mesh] | None,
    time: Time,
) -> Table:
    """At every frame, how long connections have lasted, how many hairs are simulated, and what the others are off by.

    Given the same hair without locks as `truth`, also how far points are from there; given the body that leads the
    roots, how much of what is simulated has parted from a lock, and along how much of it it could follow still.
    """
    from hairpipe.measure.locks import measure_locks as measure

    return measure(groom, hair, states, truth, body, time.fps)
