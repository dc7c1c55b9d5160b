"""Distances between ensembles of runs: differences between models of chaotic hair.

A distance matrix d, (K, K), contains the distances of all runs, those of a model, m, and those of a reference, r. Runs
of different seeds are independent; two with the same seed, one of each side, have the same start, and their distance is
excluded from means. All functions are pure, and take many matrices at once, (..., K, K).
"""

from collections.abc import Callable
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from hairpipe.errors import BadInput

CONFIDENCE = 0.9
"""Confidence of intervals and bounds."""
LIMIT = 0.95  # quantile of the distances within the reference, beyond which a model differs significantly
MOST = 20_000  # maximum number of relabellings
_ROUNDING = 1e-12


class Sides(NamedTuple):
    """Sides and seeds of the runs of an ensemble."""

    model: np.ndarray  # whether each run is of the model rather than of the reference, (K,) bool
    seeds: np.ndarray  # of the runs, different within a side, (K,) int


class Look(NamedTuple):
    """Test whether a model differs significantly from its reference in any of some observables."""

    ratios: np.ndarray  # energy distances T over their floors F, (Q,): differences within the reference are at most 1
    score: float  # Z, the largest of them; among many one often exceeds 1 by chance
    p: float  # share of all relabellings with a Z as large, which accounts for this


class Interval(NamedTuple):
    """An estimate, and the bounds between which the truth lies in 90 of 100 cases; NaN where nothing is known of it."""

    value: float
    low: float
    high: float


def sides_of(model: tuple[int, ...], reference: tuple[int, ...]) -> Sides:
    """Return the sides of runs with these seeds, those of the model first; BadInput where a seed is there twice."""
    for seeds in (model, reference):
        if len(set(seeds)) < len(seeds):
            raise BadInput(f"members {list(seeds)} are not all different", right="each member once")
    return Sides(np.arange(len(model) + len(reference)) < len(model), np.array([*model, *reference]))


def energy_distance(distances: np.ndarray, sides: Sides) -> np.ndarray:
    """Return T = 2 E d(m, r) - E d(m, m') - E d(r, r') as a U-statistic: 0 on average for equal distributions.

    It is the energy distance of Szekely and Rizzo 2004 between the distributions of runs. The spread of a side with
    one run is set to that of the other. `model` of the sides may contain many labellings, (R, K): the result is then
    (..., R).
    """
    labels = np.atleast_2d(sides.model).astype(float)
    apart = (sides.seeds[:, None] != sides.seeds).astype(float)
    cross, own, other = (
        _mean(distances, apart, one, two)
        for one, two in ((labels, 1.0 - labels), (labels, labels), (1.0 - labels, 1.0 - labels))
    )
    own, other = np.where(np.isnan(own), other, own), np.where(np.isnan(other), own, other)
    found = 2.0 * cross - own - other
    return found if sides.model.ndim > 1 else found[..., 0]


def squared_bias(distances: np.ndarray, sides: Sides) -> np.ndarray:
    """Return B^2, the squared distance of the means of both sides, without bias, so that it may be negative.

    B^2 = E d(m, r)^2 - E d(m, m')^2 / 2 - E d(r, r')^2 / 2 for a Euclidean d. Scores of small ensembles are fair since
    no run is compared with itself (Ferro 2014).
    """
    return 0.5 * energy_distance(distances**2, sides)


Statistic = Callable[[np.ndarray, Sides], np.ndarray]


def root_mean_square(squares: np.ndarray) -> np.ndarray:
    """Return the root mean square distance of two of K runs, (...,), of squared distances (..., K, K)."""
    count = squares.shape[-1]
    return np.sqrt(squares.sum(axis=(-2, -1)) / (count * (count - 1)))


def frames_within(spreads: np.ndarray, most: float) -> int:
    """Return the number of frames before the spread of a reference, (frames,), exceeds a limit."""
    return int(np.argmax(np.append(spreads > most, True)))


def spread_ratio(distances: np.ndarray, sides: Sides) -> np.ndarray:
    """Return S, the root mean square distance of two runs of the model over that of the reference; NaN of one run."""
    apart = (sides.seeds[:, None] != sides.seeds).astype(float)
    own, other = (
        _mean(distances**2, apart, side, side)[..., 0]
        for side in (np.atleast_2d(sides.model).astype(float), np.atleast_2d(~sides.model).astype(float))
    )
    return np.sqrt(own / other)


def floors(distances: np.ndarray, sides: Sides, statistic: Statistic = energy_distance) -> np.ndarray:
    """Return F, the 95 % quantile of a statistic over all splits of the reference in two, one as large as the model.

    If the model has more than half as many as the reference, halves. Raises BadInput if the reference has fewer than
    three runs.
    """
    reference = np.flatnonzero(~sides.model)
    count = len(reference)
    if count < 3:
        raise BadInput(f"{count} members of the reference", right="at least three, to estimate their spread")
    part = min(int(sides.model.sum()), count // 2)
    labels = np.array([np.isin(np.arange(count), chosen) for chosen in combinations(range(count), part)])
    _check(len(labels))
    within = distances[..., reference[:, None], reference]
    splits = Sides(labels, sides.seeds[reference])
    return np.quantile(statistic(within, splits), LIMIT, axis=-1, method="higher")


def signed_root(squares: np.ndarray) -> np.ndarray:
    """Return the roots of squares, with their sign."""
    return np.sign(squares) * np.sqrt(np.abs(squares))


def relabellings(sides: Sides) -> np.ndarray:
    """Return the relabellings of runs, (R, K) bool, that are as likely as the present one, which is the first.

    That is if both sides have one distribution. Runs whose seed is on one side only are exchanged freely, two of the
    same seed with each other. Raises BadInput if there are too many.
    """
    seeds, counts = np.unique(sides.seeds, return_counts=True)
    paired = np.isin(sides.seeds, seeds[counts == 2])
    free = np.flatnonzero(~paired)
    swaps = [np.flatnonzero(sides.seeds == seed) for seed in seeds[counts == 2]]
    chosen = list(combinations(range(len(free)), int(sides.model[free].sum())))
    _check(len(chosen) * 2 ** len(swaps))
    found = [sides.model]
    for some, flips in product(chosen, product((False, True), repeat=len(swaps))):
        labels = sides.model.copy()
        labels[free] = np.isin(np.arange(len(free)), some)
        for pair, flip in zip(swaps, flips, strict=True):
            labels[pair] ^= flip
        if not np.array_equal(labels, sides.model):
            found.append(labels)
    return np.array(found)


def look(distances: np.ndarray, sides: Sides) -> Look:
    """Test a model against its reference by the largest T / F of Q observables, relabelled together; (Q, K, K).

    One exact p for all of them, after Westfall and Young 1993. A single observable is a stack of one.
    """
    floor = floors(distances, sides)[:, None]
    found = energy_distance(distances, sides._replace(model=relabellings(sides)))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(floor > 0.0, found / floor, np.where(found > 0.0, np.inf, 0.0))
    scores = ratios.max(axis=0)
    as_large = scores >= scores[0] - _ROUNDING * abs(scores[0])
    return Look(ratios[:, 0], float(scores[0]), float(np.mean(as_large)))


def interval_of_samples(values: np.ndarray) -> Interval:
    """Return the mean of independent values, (n,), and its 90 % interval by Student's t; NaN of fewer than two.

    Patches are independent, members and restarts are; frames of a shot are not.
    """
    count = len(values)
    mean = float(np.mean(values))
    if count < 2:
        return Interval(mean, np.nan, np.nan)
    return _interval(mean, float(np.var(values, ddof=1) / count), count - 1)


def uncertainty(values: np.ndarray) -> float:
    """Return the one-sided 90 % bound of the mean of independent values, minus their mean; 0 for one value.

    It is t s / sqrt(n), with s the standard deviation of n values and t of Student's distribution with n - 1 degrees;
    `interval_of_samples` has two bounds.
    """
    count = len(values)
    return float(stdtrit(count - 1, CONFIDENCE) * np.std(values, ddof=1) / np.sqrt(count)) if count > 1 else 0.0


def interval_by_members(distances: np.ndarray, sides: Sides) -> Interval:
    """Return B^2 of one matrix and its 90 % interval by the jackknife over members of both sides (Arvesen 1969).

    It is wide and conservative. NaN if a side has fewer than two.
    """
    value = float(squared_bias(distances, sides))
    variance = 0.0
    for side in (sides.model, ~sides.model):
        members = np.flatnonzero(side)
        if len(members) < 2:
            return Interval(value, np.nan, np.nan)
        left = [np.delete(np.arange(len(side)), member) for member in members]
        found = [squared_bias(distances[np.ix_(kept, kept)], Sides(*(s[kept] for s in sides))) for kept in left]
        variance += (len(members) - 1) * float(np.var(found))
    return _interval(value, variance, len(sides.model) - 2)


def _interval(value: float, variance: float, freedom: int) -> Interval:
    """Return the interval about a value by Student's t."""
    reach = float(stdtrit(freedom, 0.5 * (1.0 + CONFIDENCE))) * np.sqrt(variance)
    return Interval(value, value - reach, value + reach)


def _mean(distances: np.ndarray, apart: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the mean distance of runs of one side and of another, (..., R), labels (R, K); NaN without any."""
    weights = one[:, :, None] * other[:, None, :] * apart
    with np.errstate(invalid="ignore"):
        return np.einsum("...ij,rij->...r", distances, weights) / weights.sum(axis=(1, 2))


def _check(count: int) -> None:
    if count > MOST:
        raise BadInput(f"{count:,} ways to relabel runs are more than {MOST:,}", right="fewer members: 8 against 8")
