"""Hair that has settled under its weight."""

from typing import Annotated

from hairpipe.data import Groom
from hairpipe.graph import node
from hairpipe.sim.material import Material
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.registry import ModelName
from hairpipe.units import Interval, MetresPerSecondSquared


@node(frames="once")
def settle_hair(
    groom: Groom,
    *,
    model: ModelName = "network",
    material: Material = Material(),  # noqa: B008 (frozen)
    construction: Construction = Construction(),  # noqa: B008
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
) -> Groom:
    """The groom as it hangs at rest: what simulated hair would sag to, without waiting for it.

    Springs rest in the groom's own shape, and nothing is in the way: hair that would sink into a body is not for this.
    Simulated sag-free, with the same material and gravity, the settled groom keeps its shape.

    model         network, chain or rod, as for simulate_hair
    material      of the fibre
    construction  of the network
    gravity       along -Y
    """
    from hairpipe.sim.statics.settle_groom import settle_groom

    return settle_groom(groom, material, construction, gravity, model)
