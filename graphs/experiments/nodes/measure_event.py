"""When something happens in a table."""

from typing import Literal

from hairpipe.data import Table
from hairpipe.graph import node


@node(frames="once")
def measure_event(
    table: Table,
    *,
    what: Literal["crossing", "period"] = "crossing",
    x: str,
    y: str,
    level: float = 0.0,
    first: float | None = None,
    last: float | None = None,
    theory: float,
) -> Table:
    """Where a column first crosses a level, or how long it takes to swing, beside what theory says.

    what    crossing of the level, or period about the mean
    x       column along which it is looked for, ascending
    y       column that is looked at
    level   that is crossed
    first   value of x from which on it is looked at; from the first row without
    last    value of x up to which it is looked at; up to the last row without
    theory  the value expected
    """
    from hairpipe.table.series import event

    return event(table, what, x, y, level, (first, last), theory)
