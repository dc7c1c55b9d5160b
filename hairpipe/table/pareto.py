"""Variants of one simulation in a table: what each costs, how far it is off, and which are worth having."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_columns
from hairpipe.errors import BadInput
from hairpipe.table.rows import numbers_of

FRONT = "on the front"


def variant_table(
    errors: Sequence[Table],
    costs: Sequence[Table],
    cases: Sequence[str],
    groups: Sequence[str],
    axes: tuple[str, str],
    floor: str = "",
) -> Table:
    """Lay the rows of variants below each other, errors beside costs, and mark those on the Pareto front with 1.

    errors, costs  of `fidelity_table` or `climate_table`, and `cost_table`, of one row each
    cases, groups  name of every variant, and of what it varies; empty: all are of one group
    axes           the cost and the error that the front is of; what failed is never on it
    floor          column of errors that are told apart from none: smaller ones count as equal to it
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
    front = on_front(cost, np.maximum(error, numbers_of(table, floor)) if floor else error)
    return table_of_columns({**columns, FRONT: front.astype(int)})


def on_front(costs: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Tell which of n variants none beats in both cost and error, (n,); those that are not finite never are."""
    finite = np.isfinite(costs) & np.isfinite(errors)
    better = (costs[:, None] <= costs) & (errors[:, None] <= errors)
    strictly = (costs[:, None] < costs) | (errors[:, None] < errors)
    return finite & ~(better & strictly & finite[:, None]).any(axis=0)
