"""Strands through motions that try an integrator."""

from typing import Annotated

from hairpipe.graphs.experiments.studies.integrators.trial import Trial

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.sim.settings import Scheme, StrainLimit
from hairpipe.units import Interval


@node(frames="once")
def follow_trial(
    *,
    trial: Trial = Trial(),  # noqa: B008 (frozen)
    scheme: Scheme = Scheme(iterations=3),  # noqa: B008
    strain: StrainLimit | None = None,
    rate: Annotated[int, Interval(ge=24, le=1_000_000)] = 15360,
) -> Table:
    """Tips, energy, stretch and speed of strands over time; in steps short enough, a run to compare others with.

    trial   what they are put through
    scheme  how a step is computed
    strain  how far a segment may be stretched; without, as far as its springs let it
    rate    steps a second
    """
    from hairpipe.graphs.experiments.studies.integrators.record import course_table

    return course_table(trial, scheme, strain, rate)
