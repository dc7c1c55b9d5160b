"""Measurements of models of a scene: tolerances, errors and times from the store, and the limits that chaos sets."""
# pyright: reportCallIssue=false

import re
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from hairpipe.app.api.reports import Task
from hairpipe.app.api.shot import Record, Shot
from hairpipe.errors import BadInput
from hairpipe.measure.climate import TESTED
from hairpipe.measure.ensemble import (
    Sides,
    floors,
    frames_within,
    root_mean_square,
    sides_of,
    spread_ratio,
    squared_bias,
    uncertainty,
)
from hairpipe.values import Table
from hairpipe.values.table import table_of_columns

LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
TIMES = {"ms": 1e-3, "s": 1.0, "min": 60.0}
NUMBER = re.compile(r"\s*(\d{1,15}(?:\.\d{1,15})?(?:[eE][+-]?\d{1,2})?)\s*([a-zA-Z%]*)\s*")


class Tolerance(NamedTuple):
    """Largest error of tips and whole strands, root mean square: in metres, or in % of the length of a strand."""

    value: float
    unit: Literal["m", "%"]

    def __str__(self) -> str:
        return f"{self.value:g} %" if self.unit == "%" else f"{1e3 * self.value:g} mm"


def read_tolerance(text: str) -> Tolerance:
    """Read a length, or a share of the length of a strand in %; BadInput for another text, or a value not above 0."""
    number, unit = take_apart(text, (*LENGTHS, "%"), "--tolerance", "2mm, or 0.5% of the length of the hair")
    return Tolerance(number, "%") if unit == "%" else Tolerance(number * LENGTHS[unit], "m")


def read_seconds(text: str, where: str) -> float:
    """Read a time [s]; BadInput for another text, or a value not above 0."""
    number, unit = take_apart(text, tuple(TIMES), where, "5s, 300ms or 2min")
    return number * TIMES[unit]


def take_apart(text: str, units: tuple[str, ...], where: str, right: str) -> tuple[float, str]:
    """Split a text into a positive number and one of these units."""
    match = NUMBER.fullmatch(text)
    if not match or float(match[1]) <= 0.0:
        raise BadInput(f"'{text}' is not a positive number with a unit", where=where, right=right)
    if match[2] not in units:
        what = f"'{text}' has no unit" if not match[2] else f"'{match[2]}' is not a valid unit here"
        raise BadInput(what, where=where, right=right)
    return float(match[1]), match[2]


REFERENCE = (0, 1, 2, 3)
MODEL = (0, 4, 5)
"""Members of model and reference: the first of each start equal, and are compared in the predictable frames."""
INDIFFERENT, LEAST = 0.2, 1e-6
"""Initial difference of the tips of members: a share of the tolerance, and a minimum [m]."""
SPREADS = (0.67, 1.5)  # accepted range of the spread of a model, over that of the reference
CHANCE = 0.05  # significance level
PLACES = ("tip", "whole")


@dataclass(frozen=True)
class Chaos:
    """Chaos of a scene, from members of the reference; lengths in the tolerance's unit.

    apart  root mean square distance of two members, of tips or of whole strands, the larger, in later frames, or
           in all frames without them
    """

    tip: float  # standard deviation of the initial tips of members [m]
    predicted: int  # number of predictable frames after the first: two members differ by at most half the tolerance
    seconds: float  # the same [s]
    frame: int  # last predictable frame
    chaotic: bool  # whether later frames exist
    apart: float
    floor: float  # smallest measurable bias of three members in later frames; 0 without them


@dataclass(frozen=True)
class Climate:
    """Differences of members of a model from those of the reference after the predictable frames."""

    bias: float  # difference of the means, of tips or of whole strands, the larger, in the tolerance's unit
    bound: float  # upper bound of the bias of strands that were not sampled
    spread: float  # spread over that of the reference
    score: float | None  # largest difference in an observable, over that within the reference; None for too few frames
    p: float | None  # probability of such a score by chance
    significant: dict[str, float]  # observables with larger differences than within the reference, and the ratios


def chaos_of(
    pairs: Mapping[tuple[int, int], Table], tolerance: Tolerance, tip: float, frames: range, fps: float
) -> Chaos:
    """Find the predictable time of hair from the tables of `measure_patches` of all pairs of the reference.

    frames  frames of the tables; the first is excluded
    """
    squares = squares_of(pairs, tolerance.unit)[:, 1:]
    count = squares.shape[-1]
    spreads = root_mean_square(squares.mean(axis=2)).max(axis=0)
    predicted = frames_within(spreads, 0.5 * tolerance.value)
    common = (tip, predicted, predicted / fps, frames[predicted], predicted < len(spreads))
    if predicted == len(spreads):
        return Chaos(*common, float(spreads.max()), 0.0)
    later = squares[:, predicted:].mean(axis=(1, 2))
    apart = root_mean_square(later).max()
    others = np.arange(count + len(MODEL))  # only their number is used
    floor = floors(np.sqrt(later), Sides(others >= count, others), squared_bias)
    return Chaos(*common, float(apart), float(np.sqrt(max(floor.max(), 0.0))))


def climate_of(pairs: Mapping[tuple[int, int], Table], look: Table, tolerance: Tolerance, chaos: Chaos) -> Climate:
    """Compare members of a model with the reference, from the tables of all pairs, those of the model first.

    look  of `measure_climate`
    """
    squares = squares_of(pairs, tolerance.unit)[:, 1 + chaos.predicted :].mean(axis=1)
    sides = sides_of(MODEL, REFERENCE)
    found = squared_bias(np.sqrt(squares), sides)
    means = found.mean(axis=1)
    bounds = [patches.mean() + uncertainty(patches) for patches in found]
    bias, bound = (float(np.sqrt(max(np.max(values), 0.0))) for values in (means, bounds))
    spread = float(spread_ratio(np.sqrt(squares[PLACES.index("whole")].mean(axis=0)), sides))
    score, p = float(look["Z"][0]), float(look["p"][0])
    if np.isnan(score):
        return Climate(bias, bound, spread, None, None, {})
    ratios = {name: float(look[f"{name} T/F"][0]) for name in TESTED}
    return Climate(bias, bound, spread, score, p, {name: ratio for name, ratio in ratios.items() if ratio > 1.0})


def squares_of(pairs: Mapping[tuple[int, int], Table], unit: str) -> np.ndarray:
    """Return the squared distances of tips and of whole strands of all pairs, (2, frames, patches, K, K)."""
    runs = 1 + max(max(pair) for pair in pairs)
    first = next(iter(pairs.values()))
    frames, patches = (len(np.unique(first[name])) for name in ("frame", "patch"))
    found = np.zeros((len(PLACES), frames, patches, runs, runs))
    for (one, other), table in pairs.items():
        for place, name in zip(found, PLACES, strict=True):
            squares = np.asarray(table[f"{name} [{unit}]"]).reshape(frames, patches) ** 2
            place[..., one, other] = place[..., other, one] = squares
    return found


def differences(climate: Climate, limit: float = 1.0) -> list[str]:
    """List statistics of a model that differ from those of the reference, the largest difference first, and the spread.

    limit  largest accepted difference in an observable, over that within the reference
    """
    ratios = climate.significant if climate.p is not None and climate.p <= CHANCE else {}
    names = sorted((name for name, ratio in ratios.items() if ratio > limit), key=lambda name: -ratios[name])
    apart = [f"{name} ({ratios[name]:.2g} times chance)" for name in names]
    if not SPREADS[0] <= climate.spread <= SPREADS[1]:
        apart.append(f"spread ({climate.spread:.2g} times that of the reference)")
    return apart


def refusal(climate: Climate, chaos: Chaos, tolerance: Tolerance, looks: float | None) -> str:
    """Return why a tolerance cannot be guaranteed for a model, independent of its errors; empty if it can.

    looks  largest accepted difference in an observable, over that within the reference; None: all are accepted
    """
    if chaos.floor > tolerance.value:
        return "the floor of chaos is above the tolerance"
    apart = [] if looks is None else differences(climate, looks)
    return f"significantly different in {', '.join(apart)}" if apart else ""


@dataclass(frozen=True)
class Measured:
    """Error and cost of a model.

    error     of tips or of whole strands, the larger, root mean square over strands and frames, in the tolerance's
              unit; for chaotic hair that of predictable frames, or the bias afterwards, the larger
    screened  whether only the predictable frames of chaotic hair were measured: enough to refuse, not to guarantee
    """

    error: float
    bound: float  # upper bound of the error of strands that were not sampled, from the spread among patches
    seconds: float  # time of a frame of the whole scene [s]
    tip: float  # root mean square distance of the tips in predictable frames [m]
    percent: float  # the same over the length of their strands [%]
    whole: float  # the same of whole strands [m]
    fault: str = ""  # reason for a missing error; the errors are then infinite
    screened: bool = False
    climate: Climate | None = None  # climate of chaotic hair
    refused: str = ""  # why the tolerance cannot be guaranteed, independent of the error

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
