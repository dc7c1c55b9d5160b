"""Simulation of strands on a body or on driven ends."""

from typing import TYPE_CHECKING, NamedTuple

from hairpipe.engine import Cuts, Pair, Time, flat_group, node
from hairpipe.laws.settings import Construction, Rest
from hairpipe.shot.settings import HairSettings
from hairpipe.strands.material import VariedMaterial
from hairpipe.strands.registry import ModelName
from hairpipe.values import BodyParts, Density, Ends, Groom, LevelSet, Mesh, Pins, Strands
from hairpipe.values.hair import HairState

if TYPE_CHECKING:
    from hairpipe.strands.hair_model import HairModels


class Hair(NamedTuple):
    """Strands of a frame, and the state from which the next frame starts."""

    strands: Strands
    state: HairState


def model_strands(
    groom: Groom, material: VariedMaterial, model: ModelName, construction: Construction, rest: Rest
) -> "HairModels":
    """Model the strands of a groom, for the whole shot."""
    from hairpipe.formats.pictures import read_image
    from hairpipe.strands.hair_model import build_models

    return build_models(groom, material, model, construction, read_image, rest.shape)


@node(frames="scan", prepare=model_strands, tuning="hairpipe.shot.tuning")
@flat_group("settings")
def simulate_hair(
    groom: Groom,
    body: Pair[Mesh] | None,
    surface: tuple[Pair[LevelSet], ...] | None,
    parts: tuple[Pair[BodyParts], ...] | None,
    ends: Pair[Ends] | None,
    target: Pair[Density] | None,
    pins: tuple[Pair[Pins], ...] | None,
    previous: HairState | None,
    time: Time,
    cuts: Cuts,
    prepared: "HairModels",
    *,
    settings: HairSettings,
) -> Hair:
    """Simulate strands as elastic rods, or as mass-spring networks after Selle, Lentine, Fedkiw 2008.

    Another model of hair is a node of its own, with strands and a state as outputs.
    """
    from hairpipe.shot.shot import Frame
    from hairpipe.shot.simulate import choose_precision, next_state, strands_of
    from hairpipe.solve.boundary import driver_of

    solid = bool(surface or parts)
    drivers = driver_of(body, ends) or (None, None)
    hair = choose_precision(settings.precision, prepared, settings, bodies=solid, first=previous is None)
    began = (time.frame - 1) * time.dt
    frame = Frame(drivers, surface or (), parts or (), began, time.dt, time.frame in cuts, target, pins or ())
    return Hair(strands_of(hair, state := next_state(hair, previous, frame, settings)), state)
