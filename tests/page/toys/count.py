"""A row a frame."""

import numpy as np

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_columns
from hairpipe.graph import Time, node


@node(frames="each")
def count(hair: Strands, time: Time) -> Table:
    """How far the hair reaches."""
    return table_of_columns({"reach [m]": [float(np.abs(hair.points).max())], "of frame": [time.frame]})
