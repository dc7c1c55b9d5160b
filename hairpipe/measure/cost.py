"""Cost of a frame, from the recorded times of results."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_rows

COLUMNS = ("seconds per frame", "fastest frame [s]", "slowest frame [s]", "frames timed")


def cost_table(nodes: Sequence[Mapping[int, float]], warm: int, timed: int) -> Table:
    """Return one row: the time of a frame of all nodes together [s]: the median, the fastest and the slowest.

    nodes  seconds of each node by frame [s]; frames missing for one of them are excluded
    warm   number of frames after the first to exclude: kernels are compiled, hair falls into its first contacts
    timed  number of frames after those; in a shot without any, the last frame is used

    All values are NaN if there is no frame to time.
    """
    seconds = list(after_the_first(nodes))
    counted = seconds[min(warm, max(len(seconds) - 1, 0)) :][:timed] or [np.nan]
    row = (float(np.median(counted)), min(counted), max(counted), min(len(counted), len(seconds)))
    return table_of_rows(COLUMNS, [row])


def after_the_first(nodes: Sequence[Mapping[int, float]]) -> Iterable[float]:
    """Sum the seconds of nodes, at every frame that all of them have but the first [s]."""
    frames = sorted(set.intersection(*(set(node) for node in nodes)))
    return (sum(node[frame] for node in nodes) for frame in frames[1:])
