"""Equilibria and stiffness of one strand, by the forces of the kernels."""

import numpy as np
import pytest

from hairpipe.studies.accuracy.sample import Sample
from hairpipe.studies.accuracy.specimen import forces, straight_specimen
from hairpipe.studies.accuracy.statics import balance, motions, stiffness


@pytest.fixture(scope="module")
def specimen():
    return straight_specimen(Sample(), 8)


def test_a_strand_at_rest_pulls_at_nothing(specimen):
    strongest = specimen.material.axial
    assert np.abs(forces(specimen, specimen.rest[None])).max() < 1e-12 * strongest


def test_stiffness_is_the_slope_of_the_forces(specimen):
    way = np.random.default_rng(5).normal(size=specimen.rest.shape) * 1e-6 * specimen.segment
    bent = specimen.rest + 1e3 * way
    moved = forces(specimen, np.stack([bent + way, bent - way]))
    change = (moved[0] - moved[1]) / 2
    expected = -(stiffness(specimen, bent) @ way.reshape(-1)).reshape(-1, 3)
    np.testing.assert_allclose(change, expected, atol=1e-6 * np.abs(expected).max())


def test_moving_and_turning_as_a_whole_costs_nothing(specimen):
    matrix = stiffness(specimen, specimen.rest)
    for axis in np.eye(3):
        shifted, rotated = np.tile(axis, (len(specimen.rest), 1)), np.cross(axis, specimen.rest)
        for way in (shifted, rotated / np.abs(rotated).max()):
            assert np.abs(matrix @ way.reshape(-1)).max() < 1e-9 * np.abs(matrix).max()


def test_under_a_small_load_it_moves_as_its_stiffness_says(specimen):
    load = np.zeros_like(specimen.rest)
    load[-1] = 1e-5 * specimen.material.bending / 0.3**2 * np.array([1.0, 2.0, 0.0])
    free = motions(specimen)
    matrix = free.T @ stiffness(specimen, specimen.rest) @ free
    way = (free @ np.linalg.solve(matrix, free.T @ load.reshape(-1))).reshape(-1, 3)
    found = balance(specimen, specimen.rest, 1e3 * load, free)
    assert found.found
    assert np.linalg.norm((found.positions - specimen.rest)[-1] - 1e3 * way[-1]) < 0.02 * np.linalg.norm(1e3 * way[-1])


def test_a_clamped_root_does_not_move_and_a_slide_moves_as_one(specimen):
    assert not motions(specimen)[:9].any()
    sliding = motions(specimen, slides=True)
    assert not sliding[:9].any() and sliding.shape[1] == 3 * (len(specimen.rest) - 6) + 1
    np.testing.assert_array_equal(sliding[-9:, -1], [0, 0, 1] * 3)
