"""Errors compared with what is allowed."""

import re
from collections.abc import Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.table.rows import numbers_of
from hairpipe.graphs.experiments.validation.row import Row, verdict_of
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

UNIT = re.compile(r"\[(.*)\]$")


def checked(
    tables: Sequence[Table],
    cases: Sequence[str],
    column: str,
    allowed: Sequence[float],
    unpromised: Sequence[str],
    texts: tuple[str, str],
) -> Table:
    """Return a row for every case: its largest magnitude in a column of errors, the allowed one, and the verdict.

    An error that is not a number is missed: the event has not happened, or there is no equilibrium.

    texts  name of the compared quantity, and the independent truth

    BadInput where tables, cases and allowed errors are not equally many, or a case that is not promised is unknown.
    """
    if not len(tables) == len(cases) == len(allowed):
        what = f"{len(tables)} tables, {len(cases)} cases, {len(allowed)} allowed errors"
        raise BadInput(what, right="a table, a name and an error for each case")
    if unknown := sorted(set(unpromised) - set(cases)):
        raise BadInput(f"no case '{unknown[0]}'", where="unpromised", right=f"one of {', '.join(cases)}")
    row, source = texts
    unit = UNIT.search(column)
    rows = []
    for table, case, bound in zip(tables, cases, allowed, strict=True):
        error = largest(table, column, case)
        verdict = verdict_of(error, bound, promised=case not in unpromised)
        rows.append(Row(row, case, error, bound, unit[1] if unit else "", verdict, source))
    return table_of_rows(Row._fields, rows)


def largest(table: Table, column: str, case: str) -> float:
    """Return the largest magnitude in a column, of a case where the table has any; NaN if one is not a number."""
    numbers = np.abs(numbers_of(table, column))
    if "case" in table.texts:
        numbers = numbers[[found == case for found in table.texts["case"]]]
    if not len(numbers):
        raise BadInput(f"no rows of the case '{case}'", right="a case of the table")
    return float(np.max(numbers))
