"""Failures of a tuft under a driven bar, by speed and step size."""

# ruff: noqa: B008 (settings are frozen)

from typing import TYPE_CHECKING, Annotated

from hairpipe.engine import node
from hairpipe.shot import settings as of
from hairpipe.strands.registry import ModelName
from hairpipe.units import Gt, Interval, MetresPerSecond, Seconds
from hairpipe.values import Table

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.studies.contact.worst import Worst

Rates = tuple[Annotated[int, Interval(ge=24, le=1_000_000)], ...]
Speeds = tuple[Annotated[MetresPerSecond, Gt(0.0)], ...]


@node(frames="once")
def measure_clash(
    truth: Table | None = None,
    *,
    model: ModelName = "network",
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
    """Measure depth, stretch, speed and failures of 32 strands that a bar is driven through and back.

    Strands are flung if they are faster than twice the converged run plus 1 m/s; the run is a table of the same form.

    model       strand model: network, rod or chain
    contact     contact of hair with the bar; if absent, there is none
    strain      strain limit of segments; if absent, the springs alone limit the strain
    scheme      time integration scheme of a step
    stiction    connections between close strands until they are pulled apart
    collisions  repulsion between strands, without penetration
    volume      drag and pressure between strands, on a grid
    locks       simulation of one strand for each group that moves together
    speeds      speeds of the bar at contact; roots follow at a quarter of it
    rates       numbers of steps per second
    seconds     duration of the run: contacts at 1/8 s and 3/8 s, rest from 1/2 s on
    """
    from dataclasses import replace

    from hairpipe.graphs.experiments.studies.contact.bar import tuft
    from hairpipe.graphs.experiments.studies.contact.clash import clash_table, fixed_steps, meet
    from hairpipe.strands.hair_model import build_hair
    from hairpipe.strands.material import Material

    hair = build_hair(tuft(), Material(), model)
    touch = contact or of.BodyContact()
    among = {"stiction": stiction, "collisions": collisions, "volume": volume, "locks": locks}
    scene = of.Scene(contact=touch, strain=strain, scheme=scheme, **among)

    def run(speed: float, rate: int) -> "Worst":
        return meet(hair, replace(scene, steps=fixed_steps(rate)), contact is not None, speed, seconds)

    return clash_table(truth, run, speeds, rates)
