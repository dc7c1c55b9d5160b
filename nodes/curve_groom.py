"""Natural curvature of hair."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Ge, Gt, Metres
from hairpipe.values import Groom


@node(frames="once")
def curve_groom(
    groom: Groom,
    *,
    radius: Annotated[Metres, Gt(0.0)] = 0.044,
    spread: Annotated[Metres, Ge(0.0)] = 0.023,
    seed: Annotated[int, Ge(0)] = 0,
) -> Groom:
    """Bend the strands of a groom by random natural curvatures, each in a random direction: waviness without weight.

    The result is the shape of hair without weight: `rest.start = "settled"` of `simulate_hair` hangs it. Strands may
    pass through the body. Defaults are measured: 2,300 hairs of Japanese women (Nagase et al. 2008).

    radius  mean curl radius of strands
    spread  standard deviation of the curl radius, whose distribution is log-normal
    seed    seed of all random numbers
    """
    from hairpipe.groom.curving import curved

    return curved(groom, radius, spread, seed)
