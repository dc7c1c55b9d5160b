"""Simulation of strands that do not begin in their rest shape."""

from typing import TYPE_CHECKING, NamedTuple

from hairpipe.engine import Pair, Time, flat_group, node
from hairpipe.laws.settings import Construction
from hairpipe.shot.settings import HairSettings
from hairpipe.strands.material import VariedMaterial
from hairpipe.strands.registry import ModelName
from hairpipe.values import Ends, Groom, Strands
from hairpipe.values.hair import HairState

if TYPE_CHECKING:
    from hairpipe.strands.hair_model import HairModel


class Hair(NamedTuple):
    """Strands of a frame, and the state from which the next frame starts."""

    strands: Strands
    state: HairState


def model_bent(
    groom: Groom, unbent: Groom, material: VariedMaterial, model: ModelName, construction: Construction
) -> "HairModel":
    """Model strands with the shape of one groom and the rest shape of another; BadInput where these differ in cut."""
    from dataclasses import replace

    import numpy as np

    from hairpipe.errors import BadInput
    from hairpipe.strands.hair_model import build_hair

    if not np.array_equal(groom.offsets, unbent.offsets):
        raise BadInput("other strands or segments than in.groom", where="in.unbent", right="the same, in another shape")
    bent = build_hair(groom, material, model, construction)
    # What touches in the groom does not collide: here that of the rest shape.
    return replace(build_hair(unbent, material, model, construction), rest=bent.rest)


@node(frames="scan", prepare=model_bent)
@flat_group("settings")
def simulate_bent(
    groom: Groom,
    unbent: Groom,
    ends: Pair[Ends],
    previous: HairState | None,
    time: Time,
    prepared: "HairModel",
    *,
    settings: HairSettings,
) -> Hair:
    """Simulate strands that begin as one groom, without twist, and have the rest shape of another.

    The node takes the settings of `simulate_hair`, and computes in double precision whatever they say.
    """
    from hairpipe.shot.shot import Frame
    from hairpipe.shot.simulate import next_state, strands_of
    from hairpipe.solve.boundary import driver_of

    drivers = driver_of(None, ends) or (None, None)
    state = next_state(prepared, previous, Frame(drivers, (), (), (time.frame - 1) * time.dt, time.dt), settings)
    return Hair(strands_of(prepared, state), state)
