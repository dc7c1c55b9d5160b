"""Rows of tables."""

from collections.abc import Sequence

from hairpipe.data import Table
from hairpipe.data.table import joined, table_of_rows
from hairpipe.errors import BadInput


def select(tables: Sequence[Table], cases: Sequence[str], column: str, value: float) -> Table:
    """Lay tables below each other, see `joined`, and keep the rows with a value in a column of numbers.

    BadInput where tables do not fit, where there is no such column, or no row is left.
    """
    try:
        table = joined(tables, cases)
    except ValueError as error:
        raise BadInput(str(error), right="tables with the same columns, and a name for each or none") from None
    if column not in table.numbers:
        raise BadInput(f"no column of numbers '{column}'", right=f"one of {', '.join(table.numbers)}")
    kept = [row for row, found in zip(table.rows(), table[column], strict=True) if found == value]
    if not kept:
        raise BadInput(f"no row has {column} = {value}", right=f"one of {sorted(set(table[column]))}")
    return table_of_rows(table.names, kept)
