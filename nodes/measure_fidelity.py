"""Accuracy of a hair simulation."""

from typing import Annotated

from hairpipe.engine import Frames, Reached, node
from hairpipe.units import Ge, Gt, MetresPerSecondSquared
from hairpipe.values import BodyParts, Groom, LevelSet, Strands, Table


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
    """Measure errors of tips and strands, energy, depth, stretch and failures against a reference: one row.

    Strands of the two simulations may differ in segments. Two grooms correspond by their ids. Hair fails at a frame
    where it is not finite, or stretched beyond `bound`; if it is not finite, its errors are infinite.

    gravity  gravitational acceleration along -Y, for the energy; 0 omits it
    bound    strain of a segment that counts as failure
    skip     number of frames to exclude at the beginning
    """
    from hairpipe.errors import BadInput
    from hairpipe.measure.fidelity import fidelity_table

    if (groom is None) != (truth_groom is None):
        raise BadInput("a groom alone", right="in.groom and in.truth_groom, or neither")
    grooms = (groom, truth_groom) if groom is not None and truth_groom is not None else None
    return fidelity_table(hair, truth, grooms, surfaces or (), parts or (), gravity, bound, skip)
