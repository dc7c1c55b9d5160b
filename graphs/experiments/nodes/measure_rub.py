"""Friction between two hairs."""

from typing import Annotated, NamedTuple

from hairpipe.engine import node
from hairpipe.laws.settings import Collisions, Scheme, StepControl
from hairpipe.strands.registry import ModelName
from hairpipe.units import Gt, Interval, MetresPerSecond
from hairpipe.values import Table


class Rubbing(NamedTuple):
    """Sliding at several speeds, and sticking."""

    sliding: Table
    sticking: Table


@node(frames="once")
def measure_rub(
    *,
    speeds: tuple[Annotated[MetresPerSecond, Gt(0.0)], ...] = (1e-3, 5e-3, 0.05),
    shares: tuple[Annotated[float, Interval(gt=0.0, lt=1.0)], ...] = (0.5, 0.9),
    model: ModelName = "rod",
    segments: Annotated[int, Interval(ge=10, le=1000)] = 25,
    collisions: Collisions = Collisions(),  # noqa: B008 (frozen)
    steps: StepControl = StepControl(),  # noqa: B008 (frozen)
    scheme: Scheme = Scheme(),  # noqa: B008 (frozen)
) -> Rubbing:
    """Press a cantilever on a hair and draw it along: friction from its lag, and creep below the limit.

    speeds      speeds of steady sliding
    shares      shares of the limit of friction at which hair is held for a second
    model       strand model of both hairs
    segments    number of segments of both hairs
    collisions  contact between the hairs
    steps       limits on the time step
    scheme      time integration scheme
    """
    from hairpipe.graphs.experiments.studies.contact.rub import Rub, rub_tables

    return Rubbing(*rub_tables(Rub(collisions, model, segments, steps, scheme), speeds, shares))
