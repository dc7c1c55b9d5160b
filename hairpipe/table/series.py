"""Events in a series: when it crosses a level, and how it swings."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput

Event = Literal["crossing", "period"]
Take = Literal["last", "largest", "smallest", "mean"]
TAKES = {"last": lambda values: values[-1], "largest": np.max, "smallest": np.min, "mean": np.mean}


def crossings(x: np.ndarray, y: np.ndarray, level: float) -> np.ndarray:
    """Return where a series y over ascending x, (n,) each, crosses a level, on straight lines between its points."""
    above = y > level
    at = np.flatnonzero(above[1:] != above[:-1])
    share = (level - y[at]) / (y[at + 1] - y[at])
    return x[at] + share * (x[at + 1] - x[at])


def period(x: np.ndarray, y: np.ndarray) -> float:
    """Return the mean period of a series that swings about its mean; NaN where it does less than one swing."""
    found = crossings(x, y, float(np.mean(y))) if len(y) else y
    return float(2.0 * np.mean(np.diff(found))) if len(found) > 2 else float("nan")


def summary(tables: Sequence[Table], columns: Sequence[str], take: Take, against: Sequence[float], name: str) -> Table:
    """Return a row for every table: one number for each of its columns, NaN left out.

    against  value that every table belongs to, in a first column of this name
    Raise BadInput where a table has no such column, or the values are not as many as the tables.
    """
    if len(against) != len(tables):
        raise BadInput(f"{len(against)} values for {len(tables)} tables", right="a value for each")
    rows = []
    for value, table in zip(against, tables, strict=True):
        known = [known_numbers(table, column) for column in columns]
        rows.append((value, *(float(TAKES[take](numbers)) if len(numbers) else np.nan for numbers in known)))
    return table_of_rows((name, *(f"{take} {column}" for column in columns)), rows)


def known_numbers(table: Table, column: str) -> np.ndarray:
    """Return the numbers of a column that are not NaN; BadInput where there is no such column of numbers."""
    if column not in table.numbers:
        raise BadInput(f"no column of numbers '{column}'", right=f"one of {', '.join(table.numbers)}")
    return table.numbers[column][~np.isnan(table.numbers[column])]


def event(
    table: Table, what: Event, x: str, y: str, level: float, window: tuple[float | None, float | None], theory: float
) -> Table:
    """Return what was measured in a column of a table, what was expected, and the difference.

    window  of x that is looked at; open where None
    Raise BadInput where there is no such column of numbers. What did not happen is NaN.
    """
    for name in (x, y):
        known_numbers(table, name)
    first, last = (-np.inf if window[0] is None else window[0]), (np.inf if window[1] is None else window[1])
    seen = (table.numbers[x] >= first) & (table.numbers[x] <= last) & np.isfinite(table.numbers[y])
    along, values = table.numbers[x][seen], table.numbers[y][seen]
    found = period(along, values) if what == "period" else next(iter(crossings(along, values, level)), np.nan)
    error = 100.0 * (found / theory - 1.0) if theory else np.nan
    row = (f"{what} of {y}", x, found, theory, error)
    return table_of_rows(("event", "along", "measured", "theory", "error [%]"), [row])
