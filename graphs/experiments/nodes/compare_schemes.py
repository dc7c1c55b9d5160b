"""Comparison of time integrators."""

from hairpipe.engine import node
from hairpipe.values import Table


@node(frames="once")
def compare_schemes(tables: tuple[Table, ...], *, schemes: tuple[str, ...]) -> Table:
    """Fit the order of each scheme, and its solves per simulated second for errors of 1, 3 and 10 % of the length.

    schemes  names of the measured schemes, in the order of their tables
    """
    from hairpipe.graphs.experiments.studies.integrators.cost import cost_table

    return cost_table(tables, schemes)
