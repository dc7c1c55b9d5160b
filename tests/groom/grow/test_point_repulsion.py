"""The push of points on each other."""

import numpy as np
import pytest

from hairpipe.groom.seeding import repulsion, sort_into_cells


@pytest.fixture
def crowd():
    random = np.random.default_rng(3)
    points = random.normal(size=(400, 3)) * 0.3
    normals = random.normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return points, normals, random.uniform(0.05, 0.5, 400)


def brute_force(points, normals, reach):
    away = points[:, None] - points[None]
    d = np.linalg.norm(away, axis=2)
    r = np.minimum(reach[:, None], reach[None])
    weight = np.where((d > 0) & (d < r) & (normals @ normals.T > 0), (r - d) / np.where(d > 0, d, 1), 0.0)
    force = np.einsum("ij,ijk->ik", weight, away)
    return force - normals * np.sum(force * normals, axis=1, keepdims=True)


@pytest.mark.parametrize("size", [0.07, 0.5, 3.0])
def test_it_is_the_sum_over_all_pairs_for_any_cells(crowd, size):
    points, normals, reach = crowd
    found = repulsion(points, normals, reach, sort_into_cells(points, size, reach.max()))
    assert np.allclose(found, brute_force(points, normals, reach), atol=1e-12)
    assert np.abs(found).max() > 0.1


def test_on_a_plane_no_momentum_is_made(crowd):
    points, _, reach = crowd
    flat = points * (1.0, 1.0, 0.0)
    force = repulsion(flat, np.tile((0.0, 0.0, 1.0), (400, 1)), reach, sort_into_cells(flat, 0.2, reach.max()))
    assert np.abs(force.sum(axis=0)).max() < 1e-11


def test_points_in_one_place_do_not_push(threads):
    points, normals, reach = np.zeros((5, 3)), np.tile((0.0, 0.0, 1.0), (5, 1)), np.ones(5)
    assert not repulsion(points, normals, reach, sort_into_cells(points, 1.0, 1.0)).any()


def test_it_does_not_depend_on_the_number_of_threads(crowd, threads):
    points, normals, reach = crowd
    cells = sort_into_cells(points, 0.3, reach.max())
    threads(1)
    alone = repulsion(points, normals, reach, cells)
    threads(2)
    assert np.array_equal(alone, repulsion(points, normals, reach, cells))
