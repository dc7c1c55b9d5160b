"""Tension of a knot."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.strands.material import Material
from hairpipe.units import Ge, Seconds
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_knot(
    groom: Groom,
    states: Frames[HairState],
    time: Time,
    *,
    material: Material = Material(),  # noqa: B008 (frozen)
    first: Annotated[Seconds, Ge(0.0)] = 0.0,
    last: Annotated[Seconds, Ge(0.0)] = 1e6,
) -> Table:
    """Compare the tension of strand 0, which has a loose knot and is held at both ends, with that of a thin rod.

    material  material of the fibre, as in simulate_hair
    first     time since the first frame at which the measurement begins
    last      time at which it ends
    """
    from hairpipe.graphs.experiments.studies.knots.overhand import loop_table

    return loop_table(groom, states, time.fps, (first, last), material)
