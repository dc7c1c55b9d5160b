"""Impulse of goals and pins."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_goal(groom: Groom, states: Frames[HairState], time: Time, *, group: str | None = None) -> Table:
    """Measure the momentum that the goal and the pins of a simulation add to its hair at every frame.

    group  name of the group of the groom to which it is added; by default all strands
    """
    from hairpipe.measure.motion import measure_impulses

    return measure_impulses(groom, states, group, time.fps)
