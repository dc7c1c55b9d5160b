"""Bias of a hair model, from restarts at states of a reference."""

from typing import Annotated, NamedTuple

from hairpipe.engine import Cuts, Frames, Time, flat_group, node
from hairpipe.shot.settings import HairSettings
from hairpipe.units import Ge
from hairpipe.values import BodyParts, Ends, Groom, LevelSet, Mesh, Strands, Table
from hairpipe.values.hair import HairState


class Restarts(NamedTuple):
    """A row of summary, and a row for every restart."""

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
    """Measure the errors of a model that restarts from states of a reference: its bias, without chaos.

    The node takes the inputs and settings of `simulate_hair` (`like = "hair"`, `type = "restart_hair"`), and strands
    and states of a reference with `checkpoint = 1`. Segments, strands and strand model must be equal to those of the
    reference.

    restarts  number of restarts, at equal intervals over the shot
    window    number of frames of each restart: after 1 the bias dominates, after 4 chaos begins
    """
    from hairpipe.graphs.experiments.measure.around import Around
    from hairpipe.graphs.experiments.measure.restarts import restart_tables
    from hairpipe.shot.simulate import choose_precision
    from hairpipe.strands.hair_model import build_models

    models = build_models(groom, settings.material, settings.model, settings.construction)
    hair = choose_precision(settings.precision, models, settings, bodies=bool(surface or parts))
    around = Around(body, ends, surface or (), parts or (), cuts)
    return Restarts(*restart_tables(hair, around, settings, (state, truth), time.dt, restarts, window))
