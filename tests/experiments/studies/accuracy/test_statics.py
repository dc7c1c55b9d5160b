"""Equilibria and stiffness of one strand, by the forces of the kernels."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import (
    forces,
    moved,
    specimen_of,
    stiffness,
    straight_specimen,
)
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, motions


@pytest.fixture(scope="module", params=["network", "rod"])
def specimen(request):
    return straight_specimen(Sample(model=request.param), 8)


def test_a_strand_at_rest_pulls_at_nothing(specimen):
    strongest = specimen.material.axial
    assert np.abs(forces(specimen, specimen.rest)).max() < 1e-12 * strongest


def test_stiffness_is_the_slope_of_the_forces_where_a_strand_is_in_equilibrium(specimen):
    free = motions(specimen)
    load = specimen.weight(np.array([0.0, 3.0, 1.0]))
    bent = balance(specimen, specimen.rest, load, free).pose
    way = free @ np.random.default_rng(5).normal(size=free.shape[1]) * 1e-6 * specimen.segment
    there, back = (forces(specimen, moved(specimen, bent, s * way.reshape(load.shape))) for s in (1, -1))
    change = free.T @ (there - back).reshape(-1) / 2
    expected = -free.T @ stiffness(specimen, bent) @ way
    np.testing.assert_allclose(change, expected, atol=1e-6 * np.abs(expected).max())


def test_moving_and_turning_as_a_whole_costs_nothing(specimen):
    matrix, x = stiffness(specimen, specimen.rest), specimen.rest.x
    for axis in np.eye(3):
        shifted, rotated = specimen.nothing(), specimen.nothing()
        shifted[:, :3], rotated[:, :3] = axis, np.cross(axis, x)
        rotated[:, 3:] = specimen.lever * axis[2]
        for way in (shifted, rotated / np.abs(rotated).max()):
            assert np.abs(matrix @ way.reshape(-1)).max() < 1e-9 * np.abs(matrix).max()


def test_under_a_small_load_it_moves_as_its_stiffness_says(specimen):
    load = specimen.nothing()
    load[specimen.tip, :3] = 1e-5 * specimen.material.bending / 0.3**2 * np.array([1.0, 2.0, 0.0])
    free = motions(specimen)
    matrix = free.T @ stiffness(specimen, specimen.rest) @ free
    way = 1e3 * (free @ np.linalg.solve(matrix, free.T @ load.reshape(-1))).reshape(load.shape)[specimen.tip, :3]
    found = balance(specimen, specimen.rest, 1e3 * load, free)
    assert found.found
    assert np.linalg.norm((found.pose.x - specimen.rest.x)[specimen.tip] - way) < 0.02 * np.linalg.norm(way)


def test_a_clamped_root_does_not_move_and_a_slide_moves_as_one(specimen):
    held = specimen.nothing()
    held[:3, :3] = 1.0
    held[:2] = 1.0
    assert not motions(specimen)[held.reshape(-1) > 0].any()
    sliding = motions(specimen, slides=True)
    end = sliding[:, -1].reshape(held.shape)
    assert not sliding[held.reshape(-1) > 0].any() and not end[:-3].any()
    np.testing.assert_array_equal(end[-3:, :3], [[0, 0, 1]] * 3)
    others = sliding[:, :-1].reshape(*held.shape, -1)
    assert others.any(axis=2)[3:-3].all() and not others[-3:].any()


def test_only_springs_of_a_network_are_guessed():
    with pytest.raises(BadInput, match="cannot be guessed"):
        specimen_of(Sample(model="rod", constants="guessed"), np.eye(3))
