"""A table per frame."""

from numeral import Numeral
from tally import tally

from hairpipe.engine import Time, node
from hairpipe.values import Table
from hairpipe.values.table import table_of_columns


@node(frames="each")
def weigh(number: Numeral, time: Time) -> Table:
    """Write a number into a table of one row."""
    tally("weigh", time.frame)
    return table_of_columns({"weight [kg]": [number.value]})
