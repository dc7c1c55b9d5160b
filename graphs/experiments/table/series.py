"""Events in a series: when it crosses a level, and how it swings."""

from typing import Literal

import numpy as np

from hairpipe.graphs.experiments.table.rows import numbers_of
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

Event = Literal["crossing", "period"]


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


def event(
    table: Table, what: Event, x: str, y: str, level: float, window: tuple[float | None, float | None], theory: float
) -> Table:
    """Return what was measured in a column of a table, what was expected, and the difference.

    window  of x that is looked at; open where None
    Raise BadInput where there is no such column of numbers. What did not happen is NaN.
    """
    for name in (x, y):
        numbers_of(table, name)
    first = -np.inf if window[0] is None else window[0]
    last = np.inf if window[1] is None else window[1]
    seen = (table.numbers[x] >= first) & (table.numbers[x] <= last) & np.isfinite(table.numbers[y])
    along, values = table.numbers[x][seen], table.numbers[y][seen]
    found = period(along, values) if what == "period" else next(iter(crossings(along, values, level)), np.nan)
    error = 100.0 * (found / theory - 1.0) if theory else np.nan
    row = (f"{what} of {y}", x, found, theory, error)
    return table_of_rows(("event", "along", "measured", "theory", "error [%]"), [row])
