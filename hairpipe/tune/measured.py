"""What was measured of one model of a scene's hair, from the tables and times that the store holds."""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from hairpipe.data import Table
from hairpipe.tune.quantity import Tolerance

CONFIDENCE = 0.9
"""How often what is promised should hold in strands that were not sampled."""


@dataclass(frozen=True)
class Measured:
    """Error and cost of a model.

    error    of tips or of whole strands, the larger, root mean square over strands and frames, in the tolerance's unit
    bound    what it may be in strands that were not sampled, judged by the spread among patches
    seconds  a frame of the whole scene [s]
    tip      root mean square distance of the tips [m]
    percent  the same in shares of the length of their strands [%]
    whole    of whole strands [m]
    fault    why there is no error; then all of those are infinite
    """

    error: float
    bound: float
    seconds: float
    tip: float
    percent: float
    whole: float
    fault: str = ""


def failed(fault: str) -> Measured:
    """Describe a model that did not get through the sample."""
    return Measured(*[float("inf")] * 6, fault)


def measured_of(table: Table, tolerance: Tolerance, seconds: float) -> Measured:
    """Sum the table of `measure_patches` up."""
    if np.any(table["lost"]):
        return failed("hair came out that is not finite")
    unit = "%" if tolerance.unit == "%" else "m"
    error, bound = np.max([bounded(table, f"{place} [{unit}]") for place in ("tip", "whole")], axis=0).tolist()
    tip, percent, whole = (bounded(table, name)[0] for name in ("tip [m]", "tip [%]", "whole [m]"))
    return Measured(error, bound, seconds, tip, percent, whole)


def bounded(table: Table, column: str) -> tuple[float, float]:
    """Return the root mean square of a column over frames and strands, and the bound that its spread allows.

    Patches of m mean squares are independent of each other, their strands and frames are not: the mean of the squares
    is known to t s / sqrt(m), with s their standard deviation and t of Student's distribution with m - 1 degrees.
    """
    patches, weights, values = (np.asarray(table[name]) for name in ("patch", "strands", column))
    squares = np.bincount(patches, weights * values**2) / np.bincount(patches, weights)
    mean = float(np.sum(weights * values**2) / np.sum(weights))
    count = len(squares)
    spread = stdtrit(count - 1, CONFIDENCE) * np.std(squares, ddof=1) / np.sqrt(count) if count > 1 else 0.0
    return float(np.sqrt(mean)), float(np.sqrt(mean + spread))


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
