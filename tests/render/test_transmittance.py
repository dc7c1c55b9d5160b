"""Compressed transmittance against the product over everything before a place."""

import numpy as np
import pytest

from hairpipe.render.deep_shadow import compress, transmittance


def fragments_of(count: int, most: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random ones, some of them at one depth, as a map holds them."""
    rng = np.random.default_rng(seed)
    depths = np.sort(np.round(rng.uniform(0.0, 40.0, count), rng.integers(0, 4)))
    return depths.astype(np.float32), rng.uniform(0.0, most, count).astype(np.float32)


def compressed(depths: np.ndarray, opacities: np.ndarray, tolerance: float) -> np.ndarray:
    """Knots, (k, 2)."""
    knots = np.full((2 * len(depths), 2), np.nan, np.float32)
    return knots[: compress(depths, opacities, tolerance, knots)]


@pytest.mark.parametrize("tolerance", [0.0, 0.005, 0.02, 0.1])
@pytest.mark.parametrize("most", [0.02, 0.3, 1.0])
def test_it_is_nowhere_farther_than_the_tolerance_from_the_product(most: float, tolerance: float) -> None:
    for seed in range(40):
        depths, opacities = fragments_of(1 + 4 * seed, most, seed)
        knots = compressed(depths, opacities, tolerance)
        between = np.linspace(-1.0, 42.0, 300)
        places = np.concatenate([between, depths, depths + np.float32(1e-3), depths - np.float32(1e-3)])
        read = [transmittance(knots, 0, len(knots), place) for place in places]
        brute = [np.prod(1.0 - opacities[depths <= place].astype(float)) for place in places]
        assert np.abs(np.array(read) - brute).max() <= tolerance + 1e-6


@pytest.mark.parametrize("most", [0.02, 0.3, 1.0])
def test_it_never_rises_and_knots_follow_one_another(most: float) -> None:
    for seed in range(40):
        knots = compressed(*fragments_of(1 + 4 * seed, most, seed), 0.02)
        assert np.isfinite(knots).all() and (np.diff(knots[:, 0]) >= 0.0).all() and (np.diff(knots[:, 1]) <= 1e-6).all()
        assert knots[0, 1] == 1.0


def test_light_that_dies_away_evenly_needs_few_knots() -> None:
    depths, opacities = np.arange(400, dtype=np.float32), np.full(400, 0.01, np.float32)
    knots = compressed(depths, opacities, 0.02)
    assert len(knots) < 10  # of chords of exp(-x) that miss it by 0.02 either way, five reach down to 0.02


def test_all_light_arrives_where_nothing_is() -> None:
    assert transmittance(np.empty((0, 2), np.float32), 0, 0, 3.0) == 1.0
