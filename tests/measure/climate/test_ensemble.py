"""Distances of ensembles, of synthetic members with known answers."""

from math import comb

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from hairpipe.errors import BadInput
from hairpipe.measure import ensemble

SIDES = ensemble.sides_of((10, 11, 12), (0, 1, 2, 3, 4))
TRIALS, DIMENSIONS, PATCHES = 600, 100, 4
SHIFTS = (0.0, 3.0, 8.0)


def members(shift, trials=TRIALS, sides=SIDES, dimensions=DIMENSIONS, seed=0):
    """Normal members, those of the model moved by a vector of some length, (trials, K, dimensions)."""
    found = np.random.default_rng(seed).standard_normal((trials, len(sides.seeds), dimensions))
    found[:, sides.model] += shift / np.sqrt(dimensions)
    return found


def distances(runs):
    """Euclidean distances of all runs, (..., K, K)."""
    squares = np.sum(runs**2, axis=-1)
    inner = runs @ np.swapaxes(runs, -1, -2)
    return np.sqrt(np.maximum(squares[..., :, None] + squares[..., None, :] - 2.0 * inner, 0.0))


def test_the_energy_distance_is_that_of_its_definition():
    runs = members(3.0, 1)[0]
    model, reference = runs[SIDES.model], runs[~SIDES.model]
    own, other = cdist(model, model), cdist(reference, reference)
    expected = 2 * cdist(model, reference).mean() - own.sum() / 6 - other.sum() / 20
    assert ensemble.energy_distance(distances(runs), SIDES) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("shift", SHIFTS)
def test_the_bias_of_ensembles_is_unbiased(shift):
    found = ensemble.squared_bias(distances(members(shift)), SIDES)
    error = np.std(found) / np.sqrt(TRIALS)
    assert abs(found.mean() - shift**2) < max(0.05 * shift**2, 3 * error)
    assert shift or (found < 0.0).mean() > 0.3  # 0 is not the least of it


def test_of_one_run_the_spread_is_that_of_the_reference():
    sides = ensemble.sides_of((7,), (0, 1, 2, 3, 4))
    found = ensemble.squared_bias(distances(members(8.0, sides=sides)), sides)
    assert found.mean() == pytest.approx(64.0, rel=0.05)


@pytest.mark.parametrize("shift", SHIFTS)
def test_nine_in_ten_intervals_by_patches_hold_the_truth(shift):
    """Each patch has a quarter of the dimensions, and its bias a quarter of the square."""
    runs = members(shift).reshape(TRIALS, len(SIDES.seeds), PATCHES, -1)
    patches = ensemble.squared_bias(distances(np.moveaxis(runs, 2, 1)), SIDES)
    intervals = ensemble.Interval(*np.array([ensemble.interval_of_samples(values) for values in patches]).T)
    holds = (intervals.low <= shift**2 / PATCHES) & (shift**2 / PATCHES <= intervals.high)
    assert 0.85 <= holds.mean() <= 0.95


@pytest.mark.parametrize("shift", SHIFTS)
def test_intervals_by_members_hold_the_truth_at_least_as_often(shift):
    found = [ensemble.interval_by_members(matrix, SIDES) for matrix in distances(members(shift, 200))]
    holds = [interval.low <= shift**2 <= interval.high for interval in found]
    assert np.mean(holds) > 0.9
    assert np.mean([interval.high - interval.low for interval in found]) < 100.0


def test_nothing_is_known_of_a_single_value():
    assert (
        ensemble.interval_of_samples(np.array([2.0]))[0] == 2.0
        and np.isnan(ensemble.interval_of_samples(np.array([2.0]))[1:]).all()
    )
    sides = ensemble.sides_of((7,), (0, 1, 2))
    assert np.isnan(ensemble.interval_by_members(distances(members(0.0, 1, sides))[0], sides).low)


def test_spreads_are_compared():
    runs = members(3.0)
    runs[:, SIDES.model] *= 0.5
    assert np.mean(ensemble.spread_ratio(distances(runs), SIDES)) == pytest.approx(0.5, rel=0.02)


def test_the_floor_is_the_largest_of_few_splits_and_halves_are_the_most():
    runs = members(30.0, 1)
    within = distances(runs)[0]
    splits = [ensemble.sides_of(one, other) for one, other in (((0, 1), (2, 3, 4)), ((1, 3), (0, 2, 4)))]
    for split in splits:
        order = 3 + split.seeds
        assert ensemble.energy_distance(within[np.ix_(order, order)], split) <= ensemble.floors(within, SIDES)
    larger = ensemble.sides_of(tuple(range(10, 19)), (0, 1, 2, 3, 4))
    padded = np.zeros((14, 14))
    padded[9:, 9:] = within[3:, 3:]
    assert ensemble.floors(padded, larger) == ensemble.floors(within, SIDES)
    assert ensemble.signed_root(ensemble.floors(within, SIDES, ensemble.squared_bias)) < 0.5 * 30.0


def test_relabellings_are_complete_and_exchange_runs_of_one_seed():
    labels = ensemble.relabellings(SIDES)
    assert len(labels) == comb(8, 3) == len(np.unique(labels, axis=0)) and np.array_equal(labels[0], SIDES.model)
    shared = ensemble.sides_of((0, 10, 11), (0, 1, 2, 3, 4))
    labels = ensemble.relabellings(shared)
    assert len(labels) == 2 * comb(6, 2) == len(np.unique(labels, axis=0))
    assert np.all(labels[:, 0] != labels[:, 3]) and np.all(labels.sum(axis=1) == 3)


def test_runs_of_one_seed_are_not_compared():
    shared = ensemble.sides_of((0, 10, 11), (0, 1, 2, 3, 4))
    matrix = distances(members(3.0, 1))[0]
    other = matrix.copy()
    other[0, 3] = other[3, 0] = 1e6
    assert ensemble.energy_distance(matrix, shared) == ensemble.energy_distance(
        other, shared
    ) and ensemble.energy_distance(matrix, SIDES) != ensemble.energy_distance(other, SIDES)


@pytest.mark.parametrize(
    "sides", [SIDES, ensemble.sides_of((0, 10, 11), (0, 1, 2, 3, 4))], ids=["own seeds", "one shared"]
)
def test_p_is_uniform_where_nothing_differs(sides):
    """Of two observables that share much; runs of one seed are near to each other."""
    runs = members(0.0, 300, sides, 8)
    runs[:, 0] = np.where(sides.seeds[0] == sides.seeds[3], 0.9 * runs[:, 3] + 0.4 * runs[:, 0], runs[:, 0])
    found = [ensemble.look(distances(np.stack([run, run**3])), sides) for run in runs]
    values = np.array([one.p for one in found])
    least = 1.0 / len(ensemble.relabellings(sides))
    for level in (0.05, 0.25, 0.5):
        exact = np.floor(level / least) * least
        assert abs(np.mean(values <= level + 1e-9) - exact) < 3.5 * np.sqrt(exact * (1 - exact) / 300)
    assert np.median([one.score for one in found]) < 1.0


def test_of_many_observables_one_is_often_beyond_its_floor_and_p_counts_that_in():
    runs = members(0.0, 8 * 300, dimensions=8).reshape(300, 8, len(SIDES.seeds), 8)
    found = [ensemble.look(matrices, SIDES) for matrices in distances(runs)]
    assert np.mean([one.score > 1.0 for one in found]) > 0.15
    assert np.mean([one.p < 0.05 for one in found]) < 0.08


def test_shift_is_significant_in_its_observable():
    runs = members(8.0, 100)
    blind = members(0.0, 100, seed=1)
    found = [ensemble.look(distances(np.stack(pair)), SIDES) for pair in zip(blind, runs, strict=True)]
    assert np.mean([one.p <= 1 / 56 + 1e-9 for one in found]) > 0.9
    assert (
        np.mean([one.ratios[1] > 1.0 for one in found]) > 0.95 and np.mean([one.ratios[0] > 1.0 for one in found]) < 0.2
    )
    assert all(one.score == one.ratios.max() for one in found)


def test_constant_observables_are_not_significant():
    same = ensemble.look(np.zeros((1, 8, 8)), SIDES)
    assert same.score == 0.0 and same.p == 1.0


def test_too_few_and_too_many_members_are_refused():
    with pytest.raises(BadInput, match="2 members of the reference"):
        ensemble.floors(np.zeros((3, 3)), ensemble.sides_of((5,), (0, 1)))
    with pytest.raises(BadInput, match="48,620 ways"):
        ensemble.relabellings(ensemble.sides_of(tuple(range(9)), tuple(range(9, 18))))
    with pytest.raises(BadInput, match="not all different"):
        ensemble.sides_of((0, 0), (1, 2))


def test_a_bound_is_kept_by_nine_means_in_ten():
    samples = np.random.default_rng(5).standard_normal((4000, 4))
    kept = np.mean([values.mean() + ensemble.uncertainty(values) >= 0.0 for values in samples])
    assert abs(kept - ensemble.CONFIDENCE) < 4.0 * np.sqrt(
        ensemble.CONFIDENCE * (1.0 - ensemble.CONFIDENCE) / len(samples)
    )
    assert ensemble.uncertainty(np.ones(1)) == 0.0


def test_distance_of_runs_is_the_mean_of_pairs_and_near_ends_at_the_first_far_frame():
    points = np.random.default_rng(6).standard_normal((5, 3))
    squares = ((points[:, None] - points) ** 2).sum(axis=2)
    pairs = [squares[i, j] for i in range(5) for j in range(i)]
    assert ensemble.root_mean_square(squares) == pytest.approx(np.sqrt(np.mean(pairs)))
    assert [ensemble.frames_within(np.array([1.0, 3.0, 1.0]), most) for most in (0.5, 2.0, 3.0)] == [0, 1, 3]
