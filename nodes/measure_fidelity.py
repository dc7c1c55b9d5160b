"""How good a hair simulation is."""

from typing import Annotated

from hairpipe.data import BodyParts, Groom, LevelSet, Strands, Table
from hairpipe.graph import Frames, Reached, node
from hairpipe.units import Ge, Gt, MetresPerSecondSquared


@node(frames="once")
def measure_fidelity(
    hair: Reached[Strands],
    truth: Frames[Strands],
    groom: Groom | None,
    truth_groom: Groom | None,
    surfaces: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    *,
    gravity: Annotated[MetresPerSecondSquared, Ge(0.0)] = 9.81,
    bound: Annotated[float, Gt(0.0)] = 0.1,
    skip: Annotated[int, Ge(0)] = 1,
) -> Table:
    """Errors of tip and strand, energy, depth in bodies, stretch, and where it failed: one row, against a reference.

    Strands of the two may be cut into other segments. Where there are two grooms, they correspond by their ids. Hair
    that is not finite at some frame, or stretched too far, has failed there; in the first case its errors are infinite.

    gravity  along -Y, for the energy; 0 leaves it out
    bound    stretch of a segment beyond which hair has failed
    skip     frames at the beginning that do not count
    """
    from hairpipe.errors import BadInput
    from hairpipe.measure.fidelity import fidelity_table

    if (groom is None) != (truth_groom is None):
        raise BadInput("a groom alone", right="in.groom and in.truth_groom, or neither")
    grooms = (groom, truth_groom) if groom is not None and truth_groom is not None else None
    return fidelity_table(hair, truth, grooms, surfaces or (), parts or (), gravity, bound, skip)
