"""Strands interpolated between key strands."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.engine import Time, node
from hairpipe.groom.key_weights import KeyWeights, weigh_keys
from hairpipe.units import Degrees, Fraction, Interval, Metres
from hairpipe.values import BodyParts, Ends, Groom, Guidance, LevelSet, Mesh, Strands


@dataclass(frozen=True)
class Clumps:
    """Clumps of strands whose tips taper towards a key strand.

    pull   displacement of the tip, as a share of its distance to the key strand
    begin  share of the length from the root that is not displaced
    """

    pull: Fraction = 0.8
    begin: Annotated[float, Interval(ge=0.0, le=0.99)] = 0.2


@node(frames="each", prepare=weigh_keys)
def interpolate_hair(
    hair: Strands,
    keys: Groom,
    groom: Groom,
    guidance: Guidance | None,
    body: Mesh | None,
    ends: Ends | None,
    surface: tuple[LevelSet, ...] | None,
    parts: tuple[BodyParts, ...] | None,
    time: Time,
    prepared: KeyWeights,
    *,
    parting: Annotated[Degrees, Interval(gt=0.0, le=180.0)] = 30.0,
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 1e-3,
    clumps: Clumps | None = None,
) -> Strands:
    """Interpolate all strands of a groom between simulated key strands.

    Strands keep the lengths of the groom; a strand that is a key itself, by id and points, is unchanged. With `surface`
    or `parts`, contact moves the other strands out of them. The ends are those of the whole groom.

    With the `guidance` of `choose_guides`, strands follow these guides; otherwise the three nearest within `parting`.

    parting    maximum angle between a strand and its key strands at rest, from root to tip
    thickness  distance kept from bodies, from the fifth point on; one fifth of it at the first
    clumps     clumps of strands about their keys; if absent, strands are independent
    """
    import numpy as np

    from hairpipe.errors import BadInput
    from hairpipe.groom.interpolating import clumped, interpolated, pushed_out
    from hairpipe.solve.boundary import driver_of, motion_of_roots

    if not np.array_equal(hair.offsets, keys.offsets):
        raise BadInput("hair and keys are not the same strands", right="in.keys: the groom that is simulated")
    shown = interpolated(hair, keys, groom, prepared, motion_of_roots(driver_of(body, ends), groom))
    if clumps is not None:
        shown = clumped(shown, hair, prepared, clumps.pull, clumps.begin)
    return pushed_out(shown, prepared.own < 0, surface or (), parts or (), thickness, time.dt)
