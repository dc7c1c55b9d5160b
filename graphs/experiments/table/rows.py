"""Rows of tables: those of one value, and one for every table."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Table
from hairpipe.values.table import joined, table_of_rows

Take = Literal["last", "largest", "smallest", "mean"]
TAKES = {"last": lambda values: values[-1], "largest": np.max, "smallest": np.min, "mean": np.mean}


def select(tables: Sequence[Table], cases: Sequence[str], column: str, value: float) -> Table:
    """Lay tables below each other, see `joined`, and keep the rows with a value in a column of numbers.

    BadInput where tables do not fit, where there is no such column, or no row is left.
    """
    try:
        table = joined(tables, cases)
    except ValueError as error:
        raise BadInput(str(error), right="tables with the same columns, and a name for each or none") from None
    numbers = numbers_of(table, column)
    kept = [row for row, found in zip(table.rows(), numbers, strict=True) if found == value]
    if not kept:
        raise BadInput(f"no row has {column} = {value}", right=f"one of {sorted(set(numbers))}")
    return table_of_rows(table.names, kept)


def summary(tables: Sequence[Table], columns: Sequence[str], take: Take, against: Sequence[float], name: str) -> Table:
    """Return a row for every table: one number for each of its columns, NaN left out.

    against  value that every table belongs to, in a first column of this name
    Raise BadInput where a table has no such column, or the values are not as many as the tables.
    """
    if len(against) != len(tables):
        raise BadInput(f"{len(against)} values for {len(tables)} tables", right="a value for each")
    rows = []
    for value, table in zip(against, tables, strict=True):
        known = (numbers[~np.isnan(numbers)] for numbers in (numbers_of(table, column) for column in columns))
        rows.append((value, *(float(TAKES[take](numbers)) if len(numbers) else np.nan for numbers in known)))
    return table_of_rows((name, *(f"{take} {column}" for column in columns)), rows)


def numbers_of(table: Table, column: str) -> np.ndarray:
    """Return the numbers of a column; BadInput where there is no such column of numbers."""
    if column not in table.numbers:
        raise BadInput(f"no column of numbers '{column}'", right=f"one of {', '.join(table.numbers)}")
    return table.numbers[column]
