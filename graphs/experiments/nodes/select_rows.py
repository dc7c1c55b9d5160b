"""Some rows of a table."""

from hairpipe.data import Table
from hairpipe.graph import node


@node(frames="once")
def select_rows(tables: tuple[Table, ...], *, cases: tuple[str, ...] = (), column: str, value: float) -> Table:
    """The rows of tables, laid below each other, that have one value in a column.

    cases   names of the tables, in order: a first column "case" names the one a row is from
    column  of numbers that is examined
    value   a number
    """
    from hairpipe.table.rows import select

    return select(tables, cases, column, value)
