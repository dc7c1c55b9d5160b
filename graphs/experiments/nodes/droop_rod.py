"""Static equilibrium of rods under gravity."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.strands.material import Material
from hairpipe.units import Gt, MetresPerSecondSquared
from hairpipe.values import Groom, Strands


@node(frames="once")
def droop_rod(
    groom: Groom,
    *,
    material: Material = Material(),  # noqa: B008 (frozen)
    gravity: Annotated[MetresPerSecondSquared, Gt(0.0)] = 9.81,
) -> Strands:
    """Compute the shape of straight strands at rest by rod theory (heavy elastica), as a reference for simulations.

    material  material of the fibre
    gravity   gravitational acceleration along -Y
    """
    from hairpipe.graphs.experiments.studies.theory.drooping import drooped

    return drooped(groom, material, gravity)
