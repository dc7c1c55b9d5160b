"""The closest point of a mesh and the side of it, against a box and a sphere, whose distances are known."""

import numpy as np
import pytest

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.groom.closest import closest, distance_and_normal, project
from hairpipe.groom.surface import site_points
from hairpipe.groom.tree import plant

HALF = np.array([0.5, 0.3, 0.2])


def make_box() -> Mesh:
    points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * HALF
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return Mesh(points, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]).astype(np.int32))


def box_distance(p):
    """Signed distance to the box, in closed form."""
    q = np.abs(p) - HALF
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


def distances_and_normals(mesh, points):
    tree = plant(mesh)
    found = [distance_and_normal(tree, tuple(p), tree.order[0]) for p in points]
    return np.array([d for d, _, _ in found]), np.array([n for _, n, _ in found])


def test_distance_to_a_box_is_exact_on_both_sides():
    points = np.random.default_rng(0).uniform(-0.6, 0.6, (3000, 3))
    exact = box_distance(points)
    assert 300 < np.count_nonzero(exact < 0) < 2700
    found, normals = distances_and_normals(make_box(), points)
    assert np.allclose(found, exact, atol=1e-14)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    moved, _ = distances_and_normals(make_box(), points + 1e-5 * normals)
    assert np.allclose(moved, exact + 1e-5, atol=1e-9)


def test_on_the_surface_the_normal_points_outside():
    on = np.array([[0.5, 0.1, 0.05], [0.2, -0.3, 0.1], [0.5, 0.3, -0.2], [0.0, 0.3, -0.2]])
    found, normals = distances_and_normals(make_box(), on)
    assert np.allclose(found, 0)
    assert np.allclose(normals[:2], [[1, 0, 0], [0, -1, 0]])
    assert np.allclose(normals[2], np.array([1, 1, -1]) / 3**0.5), "whatever the diagonals"
    assert np.allclose(normals[3], np.array([0, 1, -1]) / 2**0.5)


def test_projections_lie_on_the_mesh_at_the_distance_told(icosphere):
    mesh = icosphere(3, 1.0)
    points = np.random.default_rng(1).normal(size=(2000, 3))
    sites, distance = project(plant(mesh), points)
    assert np.allclose(np.linalg.norm(site_points(mesh, sites) - points, axis=1), distance, atol=1e-14)
    assert (sites.barycentrics >= 0).all() and np.allclose(sites.barycentrics.sum(axis=1), 1, atol=1e-14)
    assert np.abs(distance - np.abs(np.linalg.norm(points, axis=1) - 1)).max() < 0.01


def test_nothing_of_a_soup_of_triangles_is_closer():
    random = np.random.default_rng(2)
    points = random.normal(size=(60, 3))
    mesh = Mesh(points, random.permutation(60).reshape(20, 3).astype(np.int32))
    asked = random.normal(size=(100, 3)) * 2
    _, distance = project(plant(mesh), asked)
    inside = random.dirichlet([0.5, 0.5, 0.5], 4000)
    soup = np.concatenate([inside @ points[triangle] for triangle in mesh.triangles])
    sampled = np.array([np.linalg.norm(soup - p, axis=1).min() for p in asked])
    assert (distance <= sampled + 1e-12).all()
    assert (sampled - distance).max() < 0.05


def test_the_guess_does_not_change_the_answer(icosphere):
    mesh = icosphere(2, 1.0)
    tree = plant(mesh)
    for p in np.random.default_rng(3).normal(size=(50, 3)):
        answers = {closest(tree, tuple(p), guess)[3] for guess in (0, 7, len(mesh.triangles) - 1)}
        assert len(answers) == 1


def test_triangles_without_area_are_passed_over():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 2, 2.0]])
    sites, distance = project(
        plant(Mesh(points, np.array([[3, 3, 3], [0, 1, 1], [0, 1, 2]], np.int32))), points[3:] + 1
    )
    assert sites.triangles[0] == 2 and abs(distance[0] - np.linalg.norm([2.5, 2.5, 3.0])) < 1e-12
    with pytest.raises(BadInput, match="no triangle with an area"):
        plant(Mesh(points, np.array([[3, 3, 3], [0, 1, 1]], np.int32)))
