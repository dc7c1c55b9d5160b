"""Time integrators compared with each other."""

from hairpipe.data import Table
from hairpipe.graph import node


@node(frames="once")
def compare_schemes(tables: tuple[Table, ...], *, schemes: tuple[str, ...]) -> Table:
    """Order of each scheme, fitted, and its solves per simulated second for an error of 1, 3 and 10 % of the length.

    schemes  names of those that were measured, in the order of their tables
    """
    from hairpipe.graphs.experiments.studies.integrators.cost import cost_table

    return cost_table(tables, schemes)
