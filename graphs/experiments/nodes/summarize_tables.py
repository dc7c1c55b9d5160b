"""Reduction of tables to rows."""

from typing import Literal

from hairpipe.engine import node
from hairpipe.values import Table


@node(frames="once")
def summarize_tables(
    tables: tuple[Table, ...],
    *,
    columns: tuple[str, ...],
    take: Literal["last", "largest", "smallest", "mean"] = "last",
    against: tuple[float, ...],
    name: str,
) -> Table:
    """Reduce every table to one row, with the value of the varied parameter.

    columns  names of the reduced columns of numbers
    take     reduction of a column: last, largest, smallest number or mean
    against  values of the varied parameter, one per table in order
    name     name of the varied parameter, with its unit
    """
    from hairpipe.graphs.experiments.table.rows import summary

    return summary(tables, columns, take, against, name)
