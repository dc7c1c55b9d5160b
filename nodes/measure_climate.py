"""Accuracy of a simulation of chaotic hair."""

from typing import Annotated

from hairpipe.engine import Frames, Reached, Time, node
from hairpipe.units import Ge, Gt, Metres, MetresPerSecondSquared
from hairpipe.values import Strands, Table


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
    """Measure the error of predictable motion, and test whether statistics of chaotic motion differ: one row.

    `in.hair` and `in.truth` are members of `perturb_groom`, simulated by a model and by a reference. Motion is
    predictable until two members of the reference differ by half the tolerance. Until then members of equal number are
    compared; afterwards statistics of members of different numbers: position, volume, contacts, kinetic energy, strain.
    If the whole shot is predictable, hair is not chaotic, and `measure_fidelity` is sufficient. `in.half` are the first
    members of the reference with half the step size, whose error is the resolution limit. Without them the limit is the
    distance of two members of the reference, which grows with the perturbation.

    members        numbers of the members of the model, with a few of the reference's among them
    truth_members  numbers of the members of the reference, three or more for chaotic hair
    tolerance      maximum error of points, relative to the length of their strands
    predicted      number of predictable frames after the first; by default as found from the reference
    patches        number of patches of `sample_groom`, as samples for intervals; with one patch, members are the
                   samples
    reach          maximum distance of points of two strands in contact: 4 thicknesses
    gravity        gravitational acceleration in the energy
    """
    from hairpipe.errors import BadInput
    from hairpipe.measure.climate import Criteria, climate_table
    from hairpipe.measure.ensemble import sides_of

    if len(members) != len(hair) or len(truth_members) != len(truth):
        counts = f"{len(members)} and {len(truth_members)} members, {len(hair)} and {len(truth)} edges"
        raise BadInput(counts, where="members", right="as many of each")
    sides = sides_of(members, truth_members)
    criteria = Criteria(tolerance, patches, reach, gravity, time.fps, predicted)
    return climate_table(hair, truth, half or (), sides, criteria)
