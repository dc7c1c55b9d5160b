"""Cost of an error, and the order at which the error falls with the step."""

from collections.abc import Sequence

import numpy as np

from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

LEVELS = (1.0, 3.0, 10.0)
FITTED = (0.01, 20.0)
"""Range of errors [%] for the fit of the order: less is the error of the reference, more is another motion."""
COLUMNS = ("scheme", "motion", "length [m]", "order", *(f"solves for {level:g} % [1/s]" for level in LEVELS))


def cost_table(tables: Sequence[Table], schemes: Sequence[str]) -> Table:
    """Tabulate the fitted order, and solves per simulated second at which the error falls below levels for good.

    tables  of `error_table`, of one scheme each; NaN stands for never
    """
    rows = []
    for scheme, table in zip(schemes, tables, strict=True):
        whose = list(zip(table["motion"], table["length [m]"], strict=True))
        for motion, length in dict.fromkeys(whose):
            ran = zip(whose, table["failed"], strict=True)
            mine = [row for row, (other, how) in enumerate(ran) if other == (motion, length) and how != "not run"]
            steps, solves, errors = (
                table.numbers[name][mine] for name in ("step [s]", "solves [1/s]", "tip error [% of length]")
            )
            costs = (solves_for(level, solves, errors) for level in LEVELS)
            rows.append((scheme, motion, float(length), order_of(steps, errors), *costs))
    return table_of_rows(COLUMNS, rows)


def order_of(steps: np.ndarray, errors: np.ndarray) -> float:
    """Fit p of error ~ step^p by least squares of the logarithms; NaN with fewer than three errors to go by."""
    used = (errors > FITTED[0]) & (errors < FITTED[1])
    return float(np.polyfit(np.log(steps[used]), np.log(errors[used]), 1)[0]) if used.sum() > 2 else np.nan


def solves_for(level: float, solves: np.ndarray, errors: np.ndarray) -> float:
    """Interpolate logarithms where the error comes below a level and stays there; the fewest solves where it always is.

    NaN where the most solves leave more, or nothing was run; an error that is not finite is more.
    """
    order = np.argsort(solves)
    solves = solves[order]
    errors = np.where(np.isfinite(errors[order]), errors[order], np.inf)
    above = np.flatnonzero(errors > level)
    if not len(solves):
        return np.nan
    if not len(above):
        return float(solves[0])
    last = above[-1]
    if last + 1 == len(solves):
        return np.nan
    if not np.isfinite(errors[last]):
        return float(solves[last + 1])
    share = np.log(errors[last] / level) / np.log(errors[last] / errors[last + 1])
    return float(solves[last] * (solves[last + 1] / solves[last]) ** share)
