"""What was measured of one model of a scene's hair, from the tables and times that the store holds."""

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_columns
from hairpipe.measure.climate.ensemble import uncertainty
from hairpipe.tune.chaos import Climate
from hairpipe.tune.quantity import Tolerance


@dataclass(frozen=True)
class Measured:
    """Error and cost of a model.

    error     of tips or of whole strands, the larger, root mean square over strands and frames, in the tolerance's
              unit; where hair is chaotic, until it cannot be predicted, or the bias afterwards, the larger
    bound     what it may be in strands that were not sampled, judged by the spread among patches
    seconds   a frame of the whole scene [s]
    tip       root mean square distance of the tips, as far as hair can be predicted [m]
    percent   the same in shares of the length of their strands [%]
    whole     of whole strands [m]
    fault     why there is no error; then all of those are infinite
    screened  whether hair is chaotic, and only what is before that was looked at: enough to refuse, not to promise
    climate   where hair is chaotic: afterwards
    refused   why it cannot be promised to keep the tolerance, whatever the error is
    """

    error: float
    bound: float
    seconds: float
    tip: float
    percent: float
    whole: float
    fault: str = ""
    screened: bool = False
    climate: Climate | None = None
    refused: str = ""

    def keeps(self, tolerance: float) -> bool:
        """Whether that can be promised."""
        return self.bound <= tolerance and not self.refused

    def kept(self, tolerance: float) -> bool:
        """Whether a promise was kept where this was measured."""
        return self.error <= tolerance and not self.refused

    def broke(self, tolerance: float) -> bool:
        """Whether one was broken, by more than the spread among patches explains: the bound as far below the error."""
        return bool(self.fault or self.refused) or 2.0 * self.error**2 - self.bound**2 > tolerance**2


def failed(fault: str) -> Measured:
    """Describe a model that did not get through the sample."""
    return Measured(*[float("inf")] * 6, fault)


def measured_of(table: Table, tolerance: Tolerance, seconds: float, frames: Iterable[int]) -> Measured:
    """Sum the table of `measure_patches` up, at these frames; hair is lost at any."""
    if np.any(table["lost"]):
        return failed("hair is not finite")
    rows = np.isin(table["frame"], list(frames))
    table = table_of_columns({name: np.asarray(table[name])[rows] for name in table.names})
    error, bound = np.max(
        [bounded(table, f"{place} [{tolerance.unit}]") for place in ("tip", "whole")], axis=0
    ).tolist()
    tip, percent, whole = (bounded(table, name)[0] for name in ("tip [m]", "tip [%]", "whole [m]"))
    return Measured(error, bound, seconds, tip, percent, whole)


def bounded(table: Table, column: str) -> tuple[float, float]:
    """Return the root mean square of a column over frames and strands, and the bound that its spread allows."""
    patches, weights, values = (np.asarray(table[name]) for name in ("patch", "strands", column))
    squares = np.bincount(patches, weights * values**2) / np.bincount(patches, weights)
    mean = float(np.sum(weights * values**2) / np.sum(weights))
    return float(np.sqrt(mean)), float(np.sqrt(mean + uncertainty(squares)))


def seconds_per_frame(
    hair: Sequence[Sequence[float]], others: Sequence[Sequence[float]], frames: int, scale: float
) -> float:
    """Return seconds a frame of the whole scene: the median of its hair, and all of the others.

    hair    seconds of each frame of the sample, for every node that hair takes [s]
    others  seconds of each level set that was made, and of each frame of particles, which stand for the whole scene,
            for every node that makes them [s]
    frames  that were measured
    scale   strands of the scene over those of the sample
    """
    return scale * sum(map(statistics.median, hair)) + sum(statistics.median(b) * len(b) / frames for b in others if b)
