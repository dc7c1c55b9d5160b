"""Times of events in a table."""

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
    """Where a column first crosses a level, or its period of oscillation, compared with theory.

    what    crossing of the level, or period about the mean
    x       column along which it is looked for, ascending
    y       column that is examined
    level   that is crossed
    first   value of x from which on it is examined; from the first row if not given
    last    value of x up to which it is examined; up to the last row if not given
    theory  the value expected
    """
    from hairpipe.table.series import event

    return event(table, what, x, y, level, (first, last), theory)
