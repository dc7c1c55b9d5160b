"""A strand pulled along a surface."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.strands.material import Material
from hairpipe.units import Ge, Interval, Seconds
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_pull(
    groom: Groom,
    states: Frames[HairState],
    time: Time,
    *,
    friction: Annotated[float, Ge(0.0)],
    held: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.0,
    material: Material = Material(),  # noqa: B008 (frozen)
    first: Annotated[Seconds, Ge(0.0)] = 0.0,
    last: Annotated[Seconds, Ge(0.0)] = 1e6,
) -> Table:
    """Compare the force that pulls strand 0 along a level floor by its root with that of an elastic bar under friction.

    friction  Coulomb friction coefficient between hair and floor
    held      number of segments at the root that cannot be stretched
    material  material of the fibre, as in simulate_hair
    first     time since the first frame at which the measurement begins
    last      time at which it ends
    """
    from hairpipe.graphs.experiments.measure.pulls import pulled_table

    return pulled_table(groom, states, time.fps, (first, last), (friction, material, held))
