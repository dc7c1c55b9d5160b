"""Times of events in a table."""

from typing import Literal

from hairpipe.engine import node
from hairpipe.values import Table


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
    """Find the first crossing of a level in a column, or its period of oscillation, and compare it with theory.

    what    measured event: first crossing of the level, or period about the mean
    x       name of the ascending column that locates the event
    y       name of the examined column
    level   value of the crossed level
    first   value of `x` at which the search begins; by default that of the first row
    last    value of `x` at which the search ends; by default that of the last row
    theory  value expected from theory
    """
    from hairpipe.graphs.experiments.table.series import event

    return event(table, what, x, y, level, (first, last), theory)
