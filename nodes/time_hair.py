"""What a hair simulation costs."""

# ruff: noqa: B008 (settings are frozen)

from typing import Annotated, Literal

from hairpipe.data import BodyParts, Ends, Groom, LevelSet, Mesh, Table
from hairpipe.graph import Frames, Time, node
from hairpipe.sim import settings as of
from hairpipe.sim.air.wind import Wind
from hairpipe.sim.material import Material
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.registry import ModelName
from hairpipe.units import Ge, Interval, MetresPerSecondSquared


@node(frames="once")
def time_hair(
    groom: Groom,
    body: Frames[Mesh] | None,
    surface: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    ends: Frames[Ends] | None,
    time: Time,
    *,
    model: ModelName = "network",
    precision: Literal["automatic", "double", "single"] = "automatic",
    material: Material = Material(),
    construction: Construction = Construction(),
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
    air: of.Air = of.Air(),
    contact: of.BodyContact = of.BodyContact(),
    strain: of.StrainLimit | None = None,
    steps: of.StepControl = of.StepControl(),
    scheme: of.Scheme = of.Scheme(),
    sag_free: of.SagFree | None = None,
    stiction: of.Stiction | None = None,
    collisions: of.Collisions | None = None,
    wind: Wind | None = None,
    cuts: tuple[int, ...] = (),
    warm: Annotated[int, Ge(1)] = 4,
    timed: Annotated[int, Ge(1)] = 12,
) -> Table:
    """Processor seconds per frame of a simulation on one thread: its first frames once more, the median of some.

    It takes the inputs and settings of `simulate_hair`: `like = "hair"`, `type = "time_hair"`.

    model         see simulate_hair
    precision     see simulate_hair
    material      see simulate_hair
    construction  see simulate_hair
    gravity       see simulate_hair
    air           see simulate_hair
    contact       see simulate_hair
    strain        see simulate_hair
    steps         see simulate_hair
    scheme        see simulate_hair
    sag_free      see simulate_hair
    stiction      see simulate_hair
    collisions    see simulate_hair
    wind          see simulate_hair
    cuts          see simulate_hair
    warm          frames before those that count, in which kernels are compiled and hair begins to move
    timed         frames that count
    """
    from hairpipe.measure.cost import Around, cost_table
    from hairpipe.sim.hair_model import build_models
    from hairpipe.sim.precision import choose_precision

    scene = of.Scene(gravity, air, contact, strain, steps, scheme, sag_free, stiction, collisions, wind)
    models = build_models(groom, material, model, construction)
    hair = choose_precision(precision, models, scene, bodies=bool(surface or parts))
    around = Around(body, ends, surface or (), parts or ())
    return cost_table(hair, around, scene, time.frame, time.dt, cuts, warm, timed)
