"""Selection of rows of a table."""

from hairpipe.engine import node
from hairpipe.values import Table


@node(frames="once")
def select_rows(tables: tuple[Table, ...], *, cases: tuple[str, ...] = (), column: str, value: float) -> Table:
    """Select the rows of tables that have one value in a column, and concatenate them.

    cases   names of the tables, in order, for a new first column "case"
    column  name of the examined column of numbers
    value   value of the selected rows
    """
    from hairpipe.graphs.experiments.table.rows import select

    return select(tables, cases, column, value)
