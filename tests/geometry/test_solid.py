"""The side of a mesh and the way out of it, against a box, whose distances are known."""

import numpy as np
import pytest

from hairpipe.geometry.solid import EDGES, FACE, VERTICES, distance_and_normal, feature_at, feature_normals, solid_of
from hairpipe.values import Mesh

HALF = np.array([0.5, 0.3, 0.2])


@pytest.fixture
def brick(box) -> Mesh:
    return box(-HALF, HALF)


def to_box(p: np.ndarray) -> np.ndarray:
    """Signed distance to the box, in closed form."""
    q = np.abs(p) - HALF
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


def distances_and_normals(mesh: Mesh, points: np.ndarray, guess: int = 0):
    solid = solid_of(mesh)
    found = [distance_and_normal(solid, tuple(p), guess) for p in points]
    return np.array([d for d, _, _ in found]), np.array([n for _, n, _ in found])


def test_distance_to_a_box_is_exact_on_both_sides(brick):
    points = np.random.default_rng(0).uniform(-0.6, 0.6, (3000, 3))
    exact = to_box(points)
    assert 300 < np.count_nonzero(exact < 0) < 2700
    found, normals = distances_and_normals(brick, points)
    assert np.allclose(found, exact, atol=1e-14)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    moved, _ = distances_and_normals(brick, points + 1e-5 * normals)
    assert np.allclose(moved, exact + 1e-5, atol=1e-9)


def test_on_the_surface_the_normal_points_outside(brick):
    on = np.array([[0.5, 0.1, 0.05], [0.2, -0.3, 0.1], [0.5, 0.3, -0.2], [0.0, 0.3, -0.2]])
    found, normals = distances_and_normals(brick, on)
    assert np.allclose(found, 0)
    assert np.allclose(normals[:2], [[1, 0, 0], [0, -1, 0]])
    assert np.allclose(normals[2], np.array([1, 1, -1]) / 3**0.5), "whatever the diagonals"
    assert np.allclose(normals[3], np.array([0, 1, -1]) / 2**0.5)


def test_the_side_holds_where_triangles_without_area_lie_between(brick):
    sliver = np.array([[0, 1, 1], [2, 2, 2]], np.int32)
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (300, 3))
    mesh = Mesh(brick.points, np.concatenate([sliver[:1], brick.triangles, sliver[1:]]))
    assert np.allclose(distances_and_normals(mesh, points)[0], to_box(points), atol=1e-14)


def test_the_place_found_is_a_guess_that_changes_nothing(sphere):
    solid = solid_of(sphere(level=3))
    for p in np.random.default_rng(2).normal(size=(50, 3)):
        distance, normal, place = distance_and_normal(solid, tuple(p), 0)
        assert distance_and_normal(solid, tuple(p), place) == (distance, normal, place)


def test_normals_of_a_sphere_point_away_from_its_centre(sphere):
    mesh = sphere(level=4)
    normals = feature_normals(mesh)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    radial = np.stack([(a + b + c) / 3, (b + c) / 2, (c + a) / 2, (a + b) / 2, a, b, c], axis=1)
    assert np.allclose(np.linalg.norm(normals, axis=2), 1)
    assert (np.sum(normals * radial / np.linalg.norm(radial, axis=2, keepdims=True), axis=2) > 0.999).all()


def test_feature_is_found_by_zero_weights():
    assert feature_at((0.2, 0.3, 0.5)) == FACE
    assert [feature_at(w) for w in ((0.0, 0.4, 0.6), (0.4, 0.0, 0.6), (0.4, 0.6, 0.0))] == [EDGES, EDGES + 1, EDGES + 2]
    assert [feature_at(tuple(w)) for w in np.eye(3)] == [VERTICES, VERTICES + 1, VERTICES + 2]
