"""Hair led to a density: an energy, its gradient, and simulations."""

from itertools import pairwise

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.target import energy
from hairpipe.values import Density, Strands
from hairpipe.values.groom import lengths_at_points, reach_of
from hairpipe.volume.density import density_of
from hairpipe.volume.targeting import Hair, attraction, between, target_grids

RATE = 30.0


def bundle(lean, count=30, segments=10):
    """Hairs of 20 cm side by side that lean over by an angle [rad]."""
    rng = np.random.default_rng(3)
    roots = rng.uniform(0.0, 0.02, (count, 1, 3))
    along = np.linspace(0.0, 0.2, segments + 1)[:, None] * np.array([np.sin(lean), -np.cos(lean), 0.0])
    points = (roots + along).reshape(-1, 3)
    offsets = (np.arange(count + 1) * (segments + 1)).astype(np.int32)
    return Strands(points, np.zeros(points.shape, np.float32), offsets, 8e-5)


def led(strands):
    points, offsets = strands.points, strands.offsets
    return Hair(points, offsets, 1.1 * reach_of(points, offsets), lengths_at_points(points, offsets))


def grids_of(strands, cell=0.016, levels=2):
    return target_grids(density_of(strands, 0.004), cell, levels, led(strands).lengths.sum())


def test_attraction_is_down_the_gradient_of_the_energy():
    """Finite differences of the energy, for a step so short that nothing is held back; not a piece more or less."""
    hair, targets = led(bundle(0.1)), grids_of(bundle(0.6))
    dt = 1e-6
    pull = attraction(hair, targets, RATE, dt) / dt
    rng = np.random.default_rng(1)
    for at in rng.choice(len(pull), 12, replace=False):
        for c in range(3):
            ahead, behind = hair.points.copy(), hair.points.copy()
            ahead[at, c] += 1e-6
            behind[at, c] -= 1e-6
            slope = (
                energy(hair._replace(points=ahead), targets, RATE) - energy(hair._replace(points=behind), targets, RATE)
            ) / 2e-6
            assert pull[at, c] * hair.lengths[at] == pytest.approx(-slope, abs=1e-6 * np.abs(pull).max() * 0.02)


def test_small_steps_along_it_lower_the_energy_to_a_small_part():
    """Points on their own, without strands' springs."""
    hair, targets = led(bundle(0.1)), grids_of(bundle(0.3))
    energies = [energy(hair, targets, RATE)]
    for _ in range(150):
        hair = hair._replace(points=hair.points + 0.03 * attraction(hair, targets, RATE, 1 / 96))
        energies.append(energy(hair, targets, RATE))
    assert all(later <= before * (1.0 + 1e-6) for before, later in pairwise(energies))
    assert energies[-1] < 0.1 * energies[0]


def test_at_the_target_hair_is_hardly_moved():
    """Not at all, were the target not smeared over its own cells."""
    there, elsewhere = bundle(0.6), bundle(0.1)
    targets = grids_of(there)
    left, begun = (np.sqrt(np.mean(attraction(led(hair), targets, RATE, 1e-6) ** 2)) for hair in (there, elsewhere))
    assert left < 0.1 * begun


def test_neither_the_unit_nor_the_number_of_hairs_of_a_target_counts():
    density = density_of(bundle(0.6), 0.004)
    other = Density(density.low, density.cell, 37.0 * density.length, density.velocity)
    one, two = (target_grids(target, 0.02, 2, 6.0) for target in (density, other))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_allclose(a.length, b.length, rtol=1e-5)
        assert a.length.sum() * a.cell**3 == pytest.approx(6.0)


def test_a_target_moves_from_one_frame_to_the_next():
    one, two = grids_of(bundle(0.1))[0], grids_of(bundle(1.2))[0]
    half = between(one, two, 0.5)
    assert half.length.sum() == pytest.approx(0.5 * (one.length.sum() + two.length.sum()))
    assert np.abs(between(one, two, 0.0).length).sum() == pytest.approx(one.length.sum(), rel=1e-13)


def test_it_is_the_same_on_any_number_of_threads(same_on_threads):
    same_on_threads(lambda: attraction(led(bundle(0.1)), grids_of(bundle(0.6)), RATE, 1 / 96))


def test_invalid_targets_are_refused():
    density = density_of(bundle(0.6), 0.02)
    with pytest.raises(BadInput, match=r"at least 0\.02 m"):
        target_grids(density, 0.01, 1, 6.0)
    empty = Density(density.low, density.cell, np.zeros_like(density.length), density.velocity)
    with pytest.raises(BadInput, match="no hair in the target"):
        target_grids(empty, 0.02, 1, 6.0)
