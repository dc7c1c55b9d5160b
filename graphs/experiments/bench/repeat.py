"""Times of repeated runs: the median, and the scatter."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.bench.report import Case

LEAST_RUNS = 5


class Spread(NamedTuple):
    """Repeated measurements of one thing.

    median, low, high  in the same unit; half of all runs lie between low and high
    runs               so many
    """

    median: float
    low: float
    high: float
    runs: int

    def per(self, count: float) -> "Spread":
        """Divide among so many things."""
        return Spread(self.median / count, self.low / count, self.high / count, self.runs)

    def rate(self, count: float) -> "Spread":
        """Turn times into things per time; the longest time is the lowest rate."""
        return Spread(count / self.median, count / self.high, count / self.low, self.runs)

    def columns(self, unit: str = "") -> Case:
        """Lay it out as columns of a table."""
        return {f"median{unit}": self.median, f"low{unit}": self.low, f"high{unit}": self.high}


def repeat(work: Callable[[], object], seconds: float, prepare: Callable[[], object] = lambda: None) -> Spread:
    """Time work [s], again and again for so many seconds; the first run, which may compile, does not count.

    prepare  is called before each run and not timed
    """
    prepare()
    work()
    times = []
    end = time.perf_counter() + seconds
    while len(times) < LEAST_RUNS or time.perf_counter() < end:
        prepare()
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    low, median, high = np.quantile(times, [0.25, 0.5, 0.75])
    return Spread(float(median), float(low), float(high), len(times))
