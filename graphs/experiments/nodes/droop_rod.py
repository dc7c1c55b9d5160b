"""Rods at rest under their weight."""

from typing import Annotated

from hairpipe.data import Groom, Strands
from hairpipe.graph import node
from hairpipe.sim.material import Material
from hairpipe.units import Gt, MetresPerSecondSquared


@node(frames="once")
def droop_rod(
    groom: Groom,
    *,
    material: Material = Material(),  # noqa: B008 (frozen)
    gravity: Annotated[MetresPerSecondSquared, Gt(0.0)] = 9.81,
) -> Strands:
    """Straight strands as rod theory has them at rest: the heavy elastica, to compare simulated hair with.

    material  of the fibre
    gravity   along -Y
    """
    from hairpipe.graphs.experiments.studies.theory.drooping import drooped

    return drooped(groom, material, gravity)
