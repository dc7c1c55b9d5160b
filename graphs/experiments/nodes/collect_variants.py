"""Cost and error of variants in one table."""

from hairpipe.engine import node
from hairpipe.values import Table


@node(frames="once")
def collect_variants(
    errors: tuple[Table, ...],
    costs: tuple[Table, ...],
    *,
    cases: tuple[str, ...],
    groups: tuple[str, ...] = (),
    cost: str = "seconds per frame",
    error: str = "strand error [% of length]",
    floor: str = "",
    low: str = "",
    high: str = "",
) -> Table:
    """Tabulate the cost and error of every variant, and mark the Pareto front.

    cases   names of the variants, in the order of errors and costs
    groups  name of the varied quantity of each variant
    cost    name of the column of costs
    error   name of the column of errors
    floor   name of the column of resolution limits: the cheapest error below the limit is on the front; empty: no limit
    low     name of the column of lower interval bounds: overlapping intervals are equivalent; empty: no intervals
    high    name of the column of upper interval bounds
    """
    from hairpipe.graphs.experiments.table.pareto import variant_table

    return variant_table(errors, costs, cases, groups, (cost, error), floor, (low, high))
