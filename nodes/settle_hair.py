"""Static equilibrium of hair."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.laws.settings import Construction, Share
from hairpipe.strands.material import VariedMaterial
from hairpipe.strands.registry import ModelName
from hairpipe.units import Interval, MetresPerSecondSquared
from hairpipe.values import Groom


@node(frames="once")
def settle_hair(
    groom: Groom,
    *,
    model: ModelName = "rod",
    material: VariedMaterial = VariedMaterial(),  # noqa: B008 (frozen)
    construction: Construction = Construction(),  # noqa: B008
    shape: Share = Share(1.0),  # noqa: B008
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
) -> Groom:
    """Compute the static equilibrium of a groom under gravity, the shape to which simulated hair sags.

    Bodies are ignored: the node does not suit hair that sinks into a body. A simulation with `rest.balanced = 1.0`, and
    the same material and gravity, keeps the shape of the settled groom.

    model         strand model: rod, network or chain, as in simulate_hair
    material      material of the fibre
    construction  parameters of the network
    shape         share of the curvature of the groom at rest: 1 (the groom), 0 (straight hair), in between linearly
    gravity       gravitational acceleration along -Y
    """
    from hairpipe.formats.pictures import read_image
    from hairpipe.solve.settle import settle_groom

    return settle_groom(groom, material, construction, gravity, model, read_image, shape)
