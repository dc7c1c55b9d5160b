"""One motion in frames of other lengths."""

from typing import Annotated

from hairpipe.engine import Frames, flat_group, node
from hairpipe.shot.settings import HairSettings
from hairpipe.units import Ge, Gt, Interval, Seconds
from hairpipe.values import Groom, LevelSet, Table

Rates = tuple[Annotated[int, Interval(ge=1, le=1000)], ...]


@node(frames="once")
@flat_group("settings")
def measure_rates(
    groom: Groom,
    surface: tuple[Frames[LevelSet], ...] | None,
    *,
    settings: HairSettings,
    rates: Rates = (24, 30, 48, 50, 60, 100),
    every: Annotated[Seconds, Gt(0.0)] = 0.5,
    intervals: Annotated[int, Ge(1)] = 8,
    finer: Annotated[int, Ge(1)] = 8,
) -> Table:
    """Measure how far hair is from a run in shorter steps, for numbers of frames a second; bodies stand still.

    The node takes settings of `simulate_hair`; only its time step depends on the frames.

    rates      numbers of frames per second; the run in shorter steps has the first
    every      interval between two comparisons, a number of frames of every rate
    intervals  number of comparisons
    finer      factor by which the longest step of that run is shorter
    """
    from hairpipe.graphs.experiments.studies.integrators.rates import rate_table
    from hairpipe.shot.simulate import choose_precision
    from hairpipe.strands.hair_model import build_models

    models = build_models(groom, settings.material, settings.model, settings.construction)
    hair = choose_precision(settings.precision, models, settings, bodies=bool(surface))
    bodies = [some[next(iter(some))] for some in surface or ()]
    return rate_table(hair, bodies, settings, rates, (every, intervals), finer)
