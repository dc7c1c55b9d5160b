"""Members of an ensemble of grooms."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Ge, Gt, Metres
from hairpipe.values import Groom


@node(frames="once")
def perturb_groom(groom: Groom, *, member: Annotated[int, Ge(0)] = 0, tip: Annotated[Metres, Gt(0.0)] = 1e-3) -> Groom:
    """Perturb a groom imperceptibly by random rotations about the roots; member 0 is unchanged.

    Simulations of several members sample chaotic motion (`measure_climate`). Members of equal number have equal
    perturbations, strand by strand, in any selection of strands.

    member  number of the member of the ensemble
    tip     standard deviation of each component of the displacement of tips
    """
    from hairpipe.groom.sampling import perturbed

    return perturbed(groom, member, tip)
