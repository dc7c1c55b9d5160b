"""A bar driven through a tuft, at which speed and in which steps."""

# ruff: noqa: B008 (settings are frozen)

from typing import TYPE_CHECKING, Annotated

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.sim import settings as of
from hairpipe.units import Gt, Interval, MetresPerSecond, Seconds

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.studies.contact.worst import Worst

Rates = tuple[Annotated[int, Interval(ge=24, le=1_000_000)], ...]
Speeds = tuple[Annotated[MetresPerSecond, Gt(0.0)], ...]


@node(frames="once")
def measure_clash(
    truth: Table | None = None,
    *,
    contact: of.BodyContact | None = None,
    strain: of.StrainLimit | None = None,
    scheme: of.Scheme = of.Scheme(),
    stiction: of.Stiction | None = None,
    collisions: of.Collisions | None = None,
    volume: of.Volume | None = None,
    locks: of.Locks | None = None,
    speeds: Speeds = (0.5, 1.0, 2.0, 4.0, 8.0),
    rates: Rates = (24, 48, 120, 240, 480),
    seconds: Annotated[Seconds, Gt(0.0)] = 0.5,
) -> Table:
    """Depth, stretch, speed and what failed, of 32 strands that a bar is driven through and back.

    Flung are those faster than twice the converged run and 1 m/s more, which is such a table, too.

    contact     with the bar; without, there is none
    strain      how far a segment may be stretched; without, as far as its springs let it
    scheme      how a step is computed
    stiction    hair that came close sticks together until it is pulled apart
    collisions  hair pushes hair away and does not pass through it
    volume      hairs slow each other down and keep room through a grid
    locks       hair that sticks together is simulated once
    speeds      of the bar, where it meets the hair; roots go along it at a quarter of that
    rates       steps a second
    seconds     from the start; they meet after 1/8 s, and again 1/4 s later, and stand still after 1/2 s
    """
    from dataclasses import replace

    from hairpipe.graphs.experiments.studies.contact.bar import tuft
    from hairpipe.graphs.experiments.studies.contact.clash import clash_table, fixed_steps, meet

    from hairpipe.sim.hair_model import build_hair
    from hairpipe.sim.material import Material

    hair, touch = build_hair(tuft(), Material()), contact or of.BodyContact()
    among = {"stiction": stiction, "collisions": collisions, "volume": volume, "locks": locks}
    scene = of.Scene(contact=touch, strain=strain, scheme=scheme, **among)

    def run(speed: float, rate: int) -> "Worst":
        return meet(hair, replace(scene, steps=fixed_steps(rate)), contact is not None, speed, seconds)

    return clash_table(truth, run, speeds, rates)
