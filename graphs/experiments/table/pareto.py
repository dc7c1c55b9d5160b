"""Variants of one simulation in a table: what each costs, how far it is off, and which are worth having."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.table.rows import numbers_of
from hairpipe.values import Table
from hairpipe.values.table import table_of_columns

FRONT = "on the front"


def variant_table(
    errors: Sequence[Table],
    costs: Sequence[Table],
    cases: Sequence[str],
    groups: Sequence[str],
    axes: tuple[str, str],
    floor: str = "",
    bars: tuple[str, str] = ("", ""),
) -> Table:
    """Lay the rows of variants below each other, errors next to costs, and mark those on the Pareto front with 1.

    errors, costs  of `fidelity_table` or `climate_table`, and `cost_table`, of one row each
    cases, groups  name of every variant, and of what it varies; empty: all are of one group
    axes           the cost and the error that the front is of; what failed is never on it
    floor          column of resolution limits: smaller errors count as equal to the limit
    bars           columns of the ends of their intervals; without any, the errors are exact
    BadInput where there are not as many of each, or no such column.
    """
    groups = groups or [""] * len(cases)
    counts = {len(errors), len(costs), len(cases), len(groups)}
    if len(counts) > 1 or any(len(table) != 1 for table in (*errors, *costs)):
        what = f"{len(errors)} errors, {len(costs)} costs, {len(cases)} cases and {len(groups)} groups"
        raise BadInput(what, right="as many of each, tables of one row")
    columns: dict[str, Any] = {"case": list(cases), "group": list(groups)}
    for tables in (costs, errors):
        columns |= {name: [table[name][0] for table in tables] for name in tables[0].names}
    table = table_of_columns(columns)
    failed = np.array([bool(text) for text in columns["failed"]])
    cost, error = (np.where(failed, np.nan, numbers_of(table, name)) for name in axes)
    least = numbers_of(table, floor) if floor else -np.inf
    low, high = (np.maximum(numbers_of(table, name), least) if name else None for name in bars)
    front = on_front(cost, np.maximum(error, least), low, high)
    return table_of_columns({**columns, FRONT: front.astype(int)})


def on_front(
    costs: np.ndarray, errors: np.ndarray, low: np.ndarray | None = None, high: np.ndarray | None = None
) -> np.ndarray:
    """Return which of n variants none beats in both cost and error, (n,); those that are not finite never are.

    low, high  ends of intervals of errors: where two overlap neither beats the other, unless they are equally far off;
               what has none, or NaN, is exact
    """
    low, high = (errors if ends is None else np.where(np.isnan(ends), errors, ends) for ends in (low, high))
    finite = np.isfinite(costs) & np.isfinite(errors)
    cheaper = (costs[:, None] < costs) & (errors[:, None] == errors)
    better = (costs[:, None] <= costs) & (high[:, None] < low)
    return finite & ~((better | cheaper) & finite[:, None]).any(axis=0)
