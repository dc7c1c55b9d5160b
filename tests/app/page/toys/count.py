"""A row a frame."""

import numpy as np

from hairpipe.engine import Time, node
from hairpipe.values import Strands, Table
from hairpipe.values.table import table_of_columns


@node(frames="each")
def count(hair: Strands, time: Time) -> Table:
    """How far the hair reaches."""
    return table_of_columns({"reach [m]": [float(np.abs(hair.points).max())], "of frame": [time.frame]})
