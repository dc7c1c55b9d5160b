"""One row for a table."""

from typing import Literal

from hairpipe.data import Table
from hairpipe.graph import node


@node(frames="once")
def summarize_tables(
    tables: tuple[Table, ...],
    *,
    columns: tuple[str, ...],
    take: Literal["last", "largest", "smallest", "mean"] = "last",
    against: tuple[float, ...],
    name: str,
) -> Table:
    """A row for every table: what it comes to, against a value that was varied from one to the next.

    columns  of numbers that are summed up
    take     what of each: its last, largest or smallest number, or the mean
    against  the value that was varied, for every table in order
    name     of that value, with its unit
    """
    from hairpipe.table.rows import summary

    return summary(tables, columns, take, against, name)
