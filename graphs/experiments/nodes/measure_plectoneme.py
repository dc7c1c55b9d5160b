"""Torque of a strand that has coiled up around itself."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.strands.material import Material
from hairpipe.units import Degrees, Ge, Gt, Metres, Seconds
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState


@node(frames="once")
def measure_plectoneme(
    groom: Groom,
    states: Frames[HairState],
    time: Time,
    *,
    turned: Degrees,
    thickness: Annotated[Metres, Gt(0.0)],
    material: Material = Material(),  # noqa: B008 (frozen)
    first: Annotated[Seconds, Ge(0.0)] = 0.0,
    last: Annotated[Seconds, Ge(0.0)] = 1e6,
) -> Table:
    """Compare the torque of strand 0, whose ends are held and turned, and which has coiled up, with that of a thin rod.

    turned     angle by which the tip is turned against the root
    thickness  distance of axes that touch, as in simulate_hair
    material   material of the fibre, as in simulate_hair
    first      time since the first frame at which the measurement begins
    last       time at which it ends
    """
    from math import radians

    from hairpipe.graphs.experiments.studies.knots.plectoneme import coiled_table

    return coiled_table(groom, states, time.fps, (first, last), (radians(turned), thickness, material))
