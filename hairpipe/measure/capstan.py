"""A rope around a cylinder: what friction holds, Euler 1762 and Eytelwein 1808."""

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_rows

EDGE = 0.05
"""Share of the turn at either end that is left out: there the strand lifts off."""
COLUMNS = ("time [s]", "strand", "wrapped [deg]", "tension ratio [1]", "limit of friction [1]")


def measure_ratios(tension: Table, friction: float) -> Table:
    """Return a row for every time and strand of a table of tensions.

    wrapped            angle between the two places that are compared, where the strand has turned by 5 and 95 % of
                       what it turns in all
    tension ratio      the greater of the tensions there over the smaller
    limit of friction  exp(friction angle): what slips has it, what sticks has less; without the weight on the cylinder
    """
    rows = []
    keys = np.column_stack([tension["time [s]"], tension["strand"]])
    for time, strand in np.unique(keys, axis=0):
        mine = (keys == (time, strand)).all(axis=1)
        turned, pull = (np.asarray(tension[name])[mine] for name in ("turned [deg]", "tension [uN]"))
        first, last = (int(np.argmax(turned >= share * turned[-1])) for share in (EDGE, 1.0 - EDGE))
        ends, angle = pull[[first, last]], turned[last] - turned[first]
        ratio = float(ends.max() / ends.min()) if ends.min() > 0.0 else np.inf
        rows.append((time, int(strand), angle, ratio, np.exp(friction * np.radians(angle))))
    return table_of_rows(COLUMNS, rows)
