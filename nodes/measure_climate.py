"""How good a simulation of hair is whose motion is chaotic."""

from typing import Annotated

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, Reached, Time, node
from hairpipe.units import Ge, Gt, Metres, MetresPerSecondSquared


@node(frames="once")
def measure_climate(
    hair: tuple[Reached[Strands], ...],
    truth: tuple[Frames[Strands], ...],
    half: tuple[Frames[Strands], ...] | None,
    time: Time,
    *,
    members: tuple[int, ...],
    truth_members: tuple[int, ...],
    tolerance: Annotated[float, Gt(0.0)] = 0.02,
    patches: Annotated[int, Ge(1)] = 1,
    predicted: Annotated[int, Ge(1)] | None = None,
    reach: Annotated[Metres, Gt(0.0)] = 1.2e-3,
    gravity: Annotated[MetresPerSecondSquared, Gt(0.0)] = 9.81,
) -> Table:
    """Error while hair can be predicted, and whether its climate is told apart from that afterwards: one row.

    Members of `perturb_groom` simulated by a model, `in.hair`, and by a reference, `in.truth`, which says how long hair
    can be predicted: until two of them are half the tolerance apart. Until then equal members are compared, afterwards
    unequal ones, by what is seen of them: where hair is, volume, contacts, liveliness, strain. Where all of the shot
    can be predicted, hair is not chaotic, and `measure_fidelity` does as well. `in.half` are the first ones of the
    reference with half its steps: the error that nothing can be told below. Without them that is the distance of two
    members of the reference, which is more, the more `perturb_groom` moves.

    members        numbers of those of the model; one of the reference's among them, few: the others are better its own
    truth_members  numbers of those of the reference, three at least where hair is chaotic
    tolerance      of points, over the length of their strands
    predicted      frames after the first for which hair can be predicted; without, they are found as above
    patches        of `sample_groom`, by which intervals are found; of one patch, by members
    reach          up to which points of two hairs touch: 4 thicknesses
    gravity        by which energy is measured
    """
    from hairpipe.errors import BadInput
    from hairpipe.measure.climate.climate import climate_table
    from hairpipe.measure.climate.distances import Criteria
    from hairpipe.measure.climate.ensemble import sides_of

    if len(members) != len(hair) or len(truth_members) != len(truth):
        counts = f"{len(members)} and {len(truth_members)} members, {len(hair)} and {len(truth)} edges"
        raise BadInput(counts, where="members", right="as many of each")
    sides, criteria = (
        sides_of(members, truth_members),
        Criteria(tolerance, patches, reach, gravity, time.fps, predicted),
    )
    return climate_table(hair, truth, half or (), sides, criteria)
