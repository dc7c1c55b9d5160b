"""Members of an ensemble of grooms."""

from typing import Annotated

from hairpipe.data import Groom
from hairpipe.graph import node
from hairpipe.units import Ge, Gt, Metres


@node(frames="once")
def perturb_groom(groom: Groom, *, member: Annotated[int, Ge(0)] = 0, tip: Annotated[Metres, Gt(0.0)] = 1e-3) -> Groom:
    """A groom whose strands are turned about their roots by as little as nobody cares about; member 0 is as given.

    Simulations of several members show what is chance (`measure_climate`). Members of equal number are perturbed alike,
    strand by strand, whichever other strands there are.

    member  of the ensemble
    tip     standard deviation of where tips are aimed, by component
    """
    from hairpipe.groom.perturbing import perturbed

    return perturbed(groom, member, tip)
