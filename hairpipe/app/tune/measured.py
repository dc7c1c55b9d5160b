"""Measurements of one model of a scene's hair, from tables and times in the store.

Results of a run: values, and their processor time.
"""

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hairpipe.app.api.reports import Task
from hairpipe.app.api.shot import Record, Shot
from hairpipe.app.tune.chaos import Climate
from hairpipe.app.tune.quantity import Tolerance
from hairpipe.measure.ensemble import uncertainty
from hairpipe.values import Table
from hairpipe.values.table import table_of_columns


@dataclass(frozen=True)
class Measured:
    """Error and cost of a model.

    error     of tips or of whole strands, the larger, root mean square over strands and frames, in the tolerance's
              unit; for chaotic hair that of predictable frames, or the bias afterwards, the larger
    bound     upper bound of the error of strands that were not sampled, from the spread among patches
    seconds   time of a frame of the whole scene [s]
    tip       root mean square distance of the tips in predictable frames [m]
    percent   the same over the length of their strands [%]
    whole     the same of whole strands [m]
    fault     reason for a missing error; the errors are then infinite
    screened  whether only the predictable frames of chaotic hair were measured: enough to refuse, not to guarantee
    climate   climate of chaotic hair
    refused   why the tolerance cannot be guaranteed, independent of the error
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
        """Whether a tolerance can be guaranteed."""
        return self.bound <= tolerance and not self.refused

    def kept(self, tolerance: float) -> bool:
        """Whether the measured error is within a tolerance."""
        return self.error <= tolerance and not self.refused

    def broke(self, tolerance: float) -> bool:
        """Whether the error exceeds a tolerance by more than the spread among patches."""
        return bool(self.fault or self.refused) or 2.0 * self.error**2 - self.bound**2 > tolerance**2


def failed(fault: str) -> Measured:
    """Make the measurement of a model that failed on the sample."""
    return Measured(*[float("inf")] * 6, fault)


def measured_of(table: Table, tolerance: Tolerance, seconds: float, frames: Iterable[int]) -> Measured:
    """Summarise the table of `measure_patches` at these frames; a lost strand at any of them is an error."""
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
    """Return the time of a frame of the whole scene [s]: the median of its hair, and the sum of the others.

    hair    times of each frame of the sample, for every node of the hair [s]
    others  times of each level set, and of each frame of particles, which represent the whole scene, for every node
            that computes them [s]
    frames  measured frames
    scale   strands of the scene over those of the sample
    """
    return scale * sum(map(statistics.median, hair)) + sum(statistics.median(b) * len(b) / frames for b in others if b)


class Results:
    """Cached results of a shot, of a run at these frames.

    Nothing is computed; a result that is not in the cache is missing.
    """

    def __init__(self, shot: Shot, frames: Iterable[int]) -> None:
        self._shot = shot
        self._records = shot.results(frames)

    def value(self, name: str) -> Any:
        """Read the value for the shot of a node; BadInput where it has not been computed."""
        return self._shot.read(Task(name, None), self._records.get(name))

    @property
    def processor(self) -> dict[str, float]:
        """Processor time of all results, by key [s]."""
        return {record.key: time_of(record) for record in self._records.values()}

    def seconds(self, name: str, frames: Iterable[int]) -> list[float]:
        """List the processor time of a node at frames or for the shot, each result once [s]; KeyError without one."""
        targets = (f"{name}@{frame}" for frame in frames) if self._shot.nodes[name].per_frame else (name,)
        records = [self._records[target] for target in targets]
        return list({record.key: time_of(record) for record in records}.values())


def time_of(record: Record) -> float:
    return record.seconds if record.processor is None else record.processor
