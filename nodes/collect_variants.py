"""Variants of a simulation in one table."""

from hairpipe.data import Table
from hairpipe.graph import node


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
    """A row for every variant: what it costs, how far it is off, and whether no other beats it in both.

    cases   names of the variants, in the order of errors and costs
    groups  what each of them varies
    cost    column that the front is of
    error   column that the front is of
    floor   column of errors below which nothing is told apart: the cheapest is on the front; empty: there is none
    low     column where intervals of errors begin: of two that overlap neither beats the other; empty: there are none
    high    column where they end
    """
    from hairpipe.table.pareto import variant_table

    return variant_table(errors, costs, cases, groups, (cost, error), floor, (low, high))
