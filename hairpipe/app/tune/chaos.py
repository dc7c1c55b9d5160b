"""Limits of a tolerance by chaos, from the distances of all pairs of runs of a sample, patch by patch."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hairpipe.app.tune.quantity import Tolerance
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

REFERENCE = (0, 1, 2, 3)
MODEL = (0, 4, 5)
"""Members of model and reference: the first of each start equal, and are compared in the predictable frames."""
INDIFFERENT, LEAST = 0.2, 1e-6
"""Initial difference of the tips of members: a share of the tolerance, and a minimum [m]."""
SPREADS = (0.67, 1.5)
"""Accepted range of the spread of a model, over that of the reference."""
CHANCE = 0.05
"""Significance level."""
PLACES = ("tip", "whole")


@dataclass(frozen=True)
class Chaos:
    """Chaos of a scene, from members of the reference; lengths in the tolerance's unit.

    tip        standard deviation of the initial tips of members [m]
    predicted  number of predictable frames after the first: two members differ by at most half the tolerance
    seconds    the same [s]
    frame      last predictable frame
    chaotic    whether later frames exist
    apart      root mean square distance of two members, of tips or of whole strands, the larger, in later frames, or
               in all frames without them
    floor      smallest measurable bias of three members in later frames; 0 without them
    """

    tip: float
    predicted: int
    seconds: float
    frame: int
    chaotic: bool
    apart: float
    floor: float


@dataclass(frozen=True)
class Climate:
    """Differences of members of a model from those of the reference after the predictable frames.

    bias         difference of the means, of tips or of whole strands, the larger, in the tolerance's unit
    bound        upper bound of the bias of strands that were not sampled
    spread       spread over that of the reference
    score        largest difference in an observable, over that within the reference; None for too few frames
    p            probability of such a score by chance
    significant  observables with larger differences than within the reference, and the ratios
    """

    bias: float
    bound: float
    spread: float
    score: float | None
    p: float | None
    significant: dict[str, float]


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
