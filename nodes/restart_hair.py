"""A model of hair started again and again from the states of another."""

from typing import Annotated, NamedTuple

from hairpipe.data import BodyParts, Ends, Groom, LevelSet, Mesh, Strands, Table
from hairpipe.data.hair import HairState
from hairpipe.graph import Cuts, Frames, Time, flat_group, node
from hairpipe.sim.settings import HairSettings
from hairpipe.units import Ge


class Restarts(NamedTuple):
    """One row that sums up, and a row for every restart."""

    summary: Table
    windows: Table


@node(frames="once")
@flat_group("settings")
def restart_hair(
    groom: Groom,
    body: Frames[Mesh] | None,
    surface: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    ends: Frames[Ends] | None,
    state: Frames[HairState],
    truth: Frames[Strands],
    time: Time,
    cuts: Cuts,
    *,
    settings: HairSettings,
    restarts: Annotated[int, Ge(1)] = 7,
    window: Annotated[int, Ge(1)] = 1,
) -> Restarts:
    """Errors of a model that starts from a reference's own states: its bias, before chaos has grown.

    It takes the inputs and settings of `simulate_hair`, `like = "hair"`, `type = "restart_hair"`, and of a reference
    its states, all of which `checkpoint = 1` keeps, and its strands. A state cannot be carried over to other segments,
    other hairs or another strand model: that is refused.

    restarts  spread evenly over the shot
    window    frames that each runs: after 1 the bias stands out most, after 4 chaos begins to
    """
    from hairpipe.measure.climate.around import Around
    from hairpipe.measure.climate.restarts import restart_tables
    from hairpipe.sim.hair_model import build_models
    from hairpipe.sim.precision import choose_precision

    models = build_models(groom, settings.material, settings.model, settings.construction)
    hair = choose_precision(settings.precision, models, settings, bodies=bool(surface or parts))
    around = Around(body, ends, surface or (), parts or (), cuts)
    return Restarts(*restart_tables(hair, around, settings, (state, truth), time.dt, restarts, window))
