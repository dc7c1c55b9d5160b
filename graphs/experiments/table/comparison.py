"""Comparison of series with a reference: along the way, at an event, and at the end."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.table.rows import numbers_of
from hairpipe.graphs.experiments.table.series import crossings
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

Measure = Literal["difference", "crossing", "last", "change"]
COLUMNS = ("case", "measure", "measured", "reference", "error [%]")
Series = tuple[np.ndarray, np.ndarray]


def comparison(
    tables: Sequence[Table],
    reference: Table,
    cases: Sequence[str],
    columns: tuple[str, str],
    measure: Measure,
    level: float,
    last: float | None,
) -> Table:
    """Return a row for every table: a number measured in a series, that of the reference, and their difference.

    columns  names of the ascending column and of the examined one; rows without a number in either are left out
    measure  difference: largest distance from the reference at its rows, where a table is linear between its own, in %
             of the largest value of the reference; crossing: where the magnitude first exceeds the level; last: value
             of the last row; change: from the first row to the last, over the first
    last     end of the range in the ascending column; None for that of the tables

    BadInput where a table lacks a column, or the cases are not as many as the tables. What does not happen is NaN.
    """
    if len(cases) != len(tables):
        raise BadInput(f"{len(cases)} cases for {len(tables)} tables", right="a case for each")
    known = series(reference, columns, last)
    rows = []
    for case, table in zip(cases, tables, strict=True):
        found = series(table, columns, last)
        if measure == "difference":
            measured = distance(found, known)
            expected = 0.0
            error = 100.0 * measured / np.max(np.abs(known[1]))
        else:
            measured = reduced(found, measure, level)
            expected = reduced(known, measure, level)
            error = 100.0 * (measured / expected - 1.0) if expected else np.nan
        rows.append((case, f"{measure} of {columns[1]}", measured, expected, float(error)))
    return table_of_rows(COLUMNS, rows)


def series(table: Table, columns: tuple[str, str], last: float | None) -> Series:
    """Return the ascending and the examined column up to an end; BadInput where there is no row with both."""
    along, values = (numbers_of(table, column) for column in columns)
    kept = np.isfinite(along) & np.isfinite(values) & (along <= (np.inf if last is None else last))
    if not kept.any():
        raise BadInput(f"no row with {' and '.join(columns)}", right="a table with numbers in both columns")
    return along[kept], values[kept]


def distance(found: Series, known: Series) -> float:
    """Return the largest distance of a series from the rows of another on the range of both; NaN without any row."""
    along, values = known
    both = (along >= found[0][0]) & (along <= found[0][-1])
    distances = np.abs(values[both] - np.interp(along[both], *found))
    return float(np.max(distances)) if len(distances) else np.nan


def reduced(found: Series, measure: Measure, level: float) -> float:
    """Reduce a series to one number; NaN for a crossing that does not happen."""
    along, values = found
    if measure == "crossing":
        return float(next(iter(crossings(along, np.abs(values), level)), np.nan))
    return float(values[-1] / values[0] - 1.0 if measure == "change" else values[-1])
