"""Errors compared with what is allowed: a row of `hairpipe validate`."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Gt
from hairpipe.values import Table


@node(frames="once")
def check_errors(
    tables: tuple[Table, ...],
    *,
    row: str,
    source: str,
    column: str,
    cases: tuple[str, ...] = ("",),
    allowed: tuple[Annotated[float, Gt(0.0)], ...],
    unpromised: tuple[str, ...] = (),
) -> Table:
    """Compare the largest error of every case with the allowed one.

    row         name of the compared quantity
    source      independent truth: a closed form, a boundary-value solution or a converged run
    column      name of the column of errors; where a table has a column "case", the rows of the case count
    cases       names of the tables, in order
    allowed     largest allowed error of every case, in order, in the unit of the column
    unpromised  cases whose bound is not promised
    """
    from hairpipe.graphs.experiments.table.checks import checked

    return checked(tables, cases, column, allowed, unpromised, (row, source))
