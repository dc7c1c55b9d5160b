"""Sites and neighbours on meshes."""

import numpy as np

from hairpipe.values import Mesh
from hairpipe.values.triangles import (
    Sites,
    area_vectors,
    in_lowest_triangle,
    site_points,
    site_uv,
    twin_corners,
    vertex_normals,
)


def test_the_corner_across_an_edge_faces_it_from_the_other_side(sphere):
    triangles = sphere(level=2).triangles
    twins = twin_corners(triangles)
    assert (twins >= 0).all(), "a closed mesh has no border"
    corners = np.arange(twins.size).reshape(-1, 3)
    assert (twins.ravel()[twins] == corners).all()
    for t, k in np.ndindex(twins.shape):
        u, j = divmod(twins[t, k], 3)
        edge, other = set(np.delete(triangles[t], k)), set(np.delete(triangles[u], j))
        assert edge == other and t != u


def test_a_border_has_nothing_across_it(sheet):
    mesh = sheet(4, 3)
    border = np.count_nonzero(twin_corners(mesh.triangles) < 0)
    assert border == 2 * (4 + 3)


def test_vertex_pairs_are_distinguished(sheet):
    mesh = sheet(310, 310)
    order = np.random.default_rng(1).permutation(len(mesh.points)).astype(np.int32)
    assert np.count_nonzero(twin_corners(order[mesh.triangles]) < 0) == 2 * (310 + 310)


def test_edges_of_three_triangles_or_of_two_that_disagree_are_borders():
    fan = np.array([[0, 1, 2], [1, 0, 3], [1, 0, 4]], np.int32)
    assert (twin_corners(fan) == -1).all()
    turned_over = np.array([[0, 1, 2], [0, 1, 3]], np.int32)
    assert (twin_corners(turned_over) == -1).all()


def test_sites_on_edges_and_vertices_are_in_the_lowest_triangle_that_meets_there(sphere):
    mesh = sphere(level=2)
    triangles = np.repeat(np.arange(len(mesh.triangles), dtype=np.int32), 7)
    weights = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0.3, 0.7], [0.3, 0, 0.7], [0.3, 0.7, 0], [0.2, 0.3, 0.5]])
    sites = Sites(triangles, np.tile(weights, (len(mesh.triangles), 1)))
    found = in_lowest_triangle(mesh, sites)
    assert np.abs(site_points(mesh, found) - site_points(mesh, sites)).max() < 1e-15
    assert np.array_equal(found.triangles[6::7], triangles[6::7])
    for t, w, lowest in zip(triangles, sites.barycentrics, found.triangles, strict=True):
        ends = mesh.triangles[t][w > 0]
        meeting = np.flatnonzero((mesh.triangles[:, :, None] == ends).any(axis=1).all(axis=1))
        assert lowest == meeting.min()


def test_sites_reproduce_linear_functions(sheet):
    mesh = sheet(5, 7)
    random = np.random.default_rng(1)
    sites = Sites(random.integers(0, len(mesh.triangles), 50).astype(np.int32), random.dirichlet([1, 1, 1], 50))
    points = site_points(mesh, sites)
    assert np.allclose(site_uv(mesh, sites), points[:, :2], atol=1e-6)
    assert np.array_equal(site_uv(Mesh(mesh.points, mesh.triangles), sites), np.zeros((50, 2)))


def test_area_vectors_point_outside_and_add_up(sphere, sheet):
    ball = sphere(2.0, level=5)
    vectors = area_vectors(ball)
    assert np.all(np.sum(vectors * ball.points[ball.triangles[:, 0]], axis=1) > 0)
    assert abs(np.linalg.norm(vectors, axis=1).sum() / (16 * np.pi) - 1) < 5e-3
    assert np.allclose(area_vectors(sheet(3, 3)).sum(axis=0), (0, 0, 1))


def test_normals_of_a_sphere_are_radial_and_a_vertex_without_area_has_none(sphere):
    ball = sphere(2.0)
    np.testing.assert_allclose(vertex_normals(ball), ball.points / 2.0, atol=0.02)
    assert not vertex_normals(Mesh(np.zeros((4, 3)), np.array([[0, 1, 2]], np.int32))).any()
