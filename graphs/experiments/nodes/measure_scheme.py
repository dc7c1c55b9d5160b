"""Errors of a time integrator against a converged run."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.laws.settings import Scheme, StrainLimit
from hairpipe.units import Gt, Interval
from hairpipe.values import Table

Rates = tuple[Annotated[int, Interval(ge=24, le=1_000_000)], ...]


@node(frames="once")
def measure_scheme(
    truth: Table,
    *,
    trial: Trial = Trial(),  # noqa: B008 (frozen)
    scheme: Scheme = Scheme(),  # noqa: B008
    strain: StrainLimit | None = None,
    rates: Rates = (24, 48, 72, 120, 240, 480, 960, 1680),
    most: Annotated[float, Gt(0.0)] = 1e6,
) -> Table:
    """Measure tip error, energy, stretch, speed and failures of every strand of a trial, for every step size.

    trial   strands and motions, as in the converged reference
    scheme  time integration scheme of a step
    strain  strain limit of segments; if absent, the springs alone limit the strain
    rates   numbers of steps per second, multiples of 24
    most    maximum number of solves of a run; more expensive runs are skipped
    """
    from hairpipe.graphs.experiments.studies.integrators.errors import error_table

    return error_table(truth, trial, scheme, strain, rates, most)
