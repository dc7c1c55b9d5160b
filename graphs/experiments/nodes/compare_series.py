"""Series of tables compared with a reference."""

from typing import Literal

from hairpipe.engine import node
from hairpipe.values import Table


@node(frames="once")
def compare_series(
    tables: tuple[Table, ...],
    reference: Table,
    *,
    cases: tuple[str, ...],
    x: str,
    y: str,
    measure: Literal["difference", "crossing", "last", "change"] = "difference",
    level: float = 0.0,
    last: float | None = None,
) -> Table:
    """Compare a column of tables with that of a reference, in one row for every table.

    cases    names of the tables, in order
    x        name of the ascending column
    y        name of the examined column
    measure  compared number: difference (largest distance from the reference at its rows; the error is in percent of
             its largest value), crossing (value of `x` where the magnitude first exceeds the level), last (value of the
             last row), or change (from the first row to the last, over the first)
    level    level of the crossing
    last     value of `x` at which the comparison ends; by default that of the last row
    """
    from hairpipe.graphs.experiments.table.comparison import comparison

    return comparison(tables, reference, cases, (x, y), measure, level, last)
