"""A strand around a post."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.units import Ge, Seconds
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_wrap(
    groom: Groom,
    states: Frames[HairState],
    time: Time,
    *,
    friction: Annotated[float, Ge(0.0)],
    first: Annotated[Seconds, Ge(0.0)] = 0.0,
    last: Annotated[Seconds, Ge(0.0)] = 1e6,
) -> Table:
    """Compare the tensions of strand 0 on both sides of a post over which it slides with Euler and Eytelwein.

    friction  Coulomb friction coefficient between hair and post
    first     time since the first frame at which the measurement begins
    last      time at which it ends
    """
    from hairpipe.graphs.experiments.measure.wraps import wrapped_table

    return wrapped_table(groom, states, time.fps, friction, (first, last))
