"""Converged reference runs for time integrators."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.laws.settings import Scheme, StrainLimit
from hairpipe.units import Interval
from hairpipe.values import Table


@node(frames="once")
def follow_trial(
    *,
    trial: Trial = Trial(),  # noqa: B008 (frozen)
    scheme: Scheme = Scheme(iterations=3),  # noqa: B008
    strain: StrainLimit | None = None,
    rate: Annotated[int, Interval(ge=24, le=1_000_000)] = 15360,
) -> Table:
    """Tabulate tips, energy, stretch and speed of strands over time; with short steps, a converged reference.

    trial   strands and their motions
    scheme  time integration scheme of a step
    strain  strain limit of segments; if absent, the springs alone limit the strain
    rate    number of steps per second
    """
    from hairpipe.graphs.experiments.studies.integrators.record import course_table

    return course_table(trial, scheme, strain, rate)
