"""What a hair simulation costs."""

from typing import Annotated

from hairpipe.data import BodyParts, Ends, Groom, LevelSet, Mesh, Table
from hairpipe.graph import Cuts, Frames, Time, flat_group, node
from hairpipe.sim.settings import HairSettings
from hairpipe.units import Ge


@node(frames="once")
@flat_group("settings")
def time_hair(
    groom: Groom,
    body: Frames[Mesh] | None,
    surface: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    ends: Frames[Ends] | None,
    time: Time,
    cuts: Cuts,
    *,
    settings: HairSettings,
    warm: Annotated[int, Ge(1)] = 4,
    timed: Annotated[int, Ge(1)] = 12,
) -> Table:
    """Processor seconds per frame of a simulation on one thread: its first frames once more, the median of some.

    It takes the inputs and settings of `simulate_hair`: `like = "hair"`, `type = "time_hair"`.

    warm   frames before those that count, in which kernels are compiled and hair begins to move
    timed  frames that count
    """
    from hairpipe.measure.cost import Around, cost_table, hair_advance
    from hairpipe.sim.hair_model import build_models
    from hairpipe.sim.precision import choose_precision

    models = build_models(groom, settings.material, settings.model, settings.construction)
    hair = choose_precision(settings.precision, models, settings, bodies=bool(surface or parts))
    around = Around(body, ends, surface or (), parts or (), cuts)
    frames = around.frames(time.frame, 1 + warm + timed)
    return cost_table(hair_advance(hair, around, settings, time.dt), frames, hair.layout.particles, warm, timed)
