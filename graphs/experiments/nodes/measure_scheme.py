"""A time integrator against a converged run."""

from typing import Annotated

from hairpipe.graphs.experiments.studies.integrators.trial import Trial

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.sim.settings import Scheme, StrainLimit
from hairpipe.units import Gt, Interval

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
    """Error of the tip, energy, stretch, speed and what failed, of every strand of a trial with every step.

    trial   what the converged run was put through, too
    scheme  how a step is computed
    strain  how far a segment may be stretched; without, as far as its springs let it
    rates   steps a second, a multiple of 24 of them
    most    solves of a run; with more it is not run
    """
    from hairpipe.graphs.experiments.studies.integrators.errors import error_table

    return error_table(truth, trial, scheme, strain, rates, most)
