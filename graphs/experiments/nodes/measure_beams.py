"""Cantilevers that press on each other."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.strands.material import Material
from hairpipe.units import Gt, Metres
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_beams(
    hair: Frames[Strands],
    *,
    thickness: Annotated[Metres, Gt(0.0)],
    material: Material = Material(),  # noqa: B008 (frozen)
) -> Table:
    """Compare two strands that cross and press on each other at the last frame with beams.

    thickness  distance kept between the axes, as in simulate_hair
    material   material of the fibre, as in simulate_hair
    """
    from hairpipe.graphs.experiments.measure.beams import pressed_table

    frames = list(hair)
    return pressed_table(hair[frames[0]], hair[frames[-1]], thickness, material)
