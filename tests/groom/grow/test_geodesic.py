"""Walking straight on over a mesh."""

import numpy as np
import pytest

from hairpipe.geometry.triangle_tree import project, tree_over
from hairpipe.groom.seeding import survey, walk_all
from hairpipe.values import Mesh
from hairpipe.values.triangles import Sites, site_points


def walked(mesh, start, move, passable=None):
    """Where the points of a mesh closest to `start` come to by a move."""
    sites, _ = project(tree_over(mesh.points[mesh.triangles]), start)
    terrain = survey(mesh, np.ones(len(mesh.triangles), bool) if passable is None else passable)
    triangles, barycentrics = sites.triangles.copy(), sites.barycentrics.copy()
    walk_all(*terrain, triangles, barycentrics, np.broadcast_to(move, start.shape).copy())
    assert (barycentrics >= 0).all() and np.allclose(barycentrics.sum(axis=1), 1)
    return Sites(triangles, barycentrics), site_points(mesh, Sites(triangles, barycentrics))


def make_prism(sides: int, floors: int) -> Mesh:
    """An open prism about the y axis with sides of length 1 and floors of height 1."""
    radius = 0.5 / np.sin(np.pi / sides)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([radius * np.sin(angle), np.zeros(sides), radius * np.cos(angle)], axis=1)
    points = np.concatenate([ring + np.array([0, floor, 0]) for floor in range(floors + 1)])
    i, j = (g.ravel() for g in np.meshgrid(np.arange(sides), np.arange(floors)))
    a, b = j * sides + i, j * sides + (i + 1) % sides
    triangles = np.concatenate([np.stack([a, b, b + sides], 1), np.stack([a, b + sides, a + sides], 1)])
    return Mesh(points, triangles.astype(np.int32))


def test_on_a_plane_a_walk_is_a_straight_line(sheet):
    random = np.random.default_rng(0)
    start = np.column_stack([random.uniform(0.3, 0.7, (200, 2)), np.zeros(200)])
    move = np.column_stack([random.uniform(-0.3, 0.3, (200, 2)), np.zeros(200)])
    _, end = walked(sheet(13, 9), start, move)
    assert np.allclose(end, start + move, atol=1e-12)


def test_at_a_border_a_walk_slides_on(sheet):
    start = np.array([[0.5, 0.5, 0.0], [0.31, 0.77, 0.0], [0.9, 0.1, 0.0]])
    _, end = walked(sheet(10, 10), start, (3.0, 0.2, 0.0))
    assert np.allclose(end, np.column_stack([np.ones(3), start[:, 1] + 0.2, np.zeros(3)]), atol=1e-9)
    _, corner = walked(sheet(10, 10), start, (3.0, 4.0, 0.0))
    assert np.allclose(corner, (1, 1, 0), atol=1e-9)


@pytest.mark.parametrize("turns", [1, -2])
def test_a_walk_around_a_prism_ends_above_where_it_began(turns):
    sides, rise = 7, 1.7
    prism = make_prism(sides, 4)
    _, middle = walked(prism, np.array([[0.0, 1.3, 10.0], [1.0, 0.2, 0.3]]), (0.0, 0.0, 0.0))
    t = Sites(*project(tree_over(prism.points[prism.triangles]), middle)[0]).triangles
    a, b = prism.points[prism.triangles[t, 0]], prism.points[prism.triangles[t, 1]]
    along = b - a
    along[:, 1] = 0.0
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    _, end = walked(prism, middle, turns * sides * along + np.array([0.0, rise, 0.0]))
    assert np.allclose(end - middle, (0, rise, 0), atol=1e-9)


def test_nothing_walks_into_what_is_not_passable(sheet):
    mesh = sheet(10, 10)
    passable = mesh.points[mesh.triangles][:, :, 0].max(axis=1) < 0.65
    sites, end = walked(mesh, np.array([[0.2, 0.35, 0.0], [0.55, 0.5, 0.0]]), (0.9, 0.1, 0.0), passable)
    assert passable[sites.triangles].all()
    assert np.allclose(end[:, 0], 0.6) and np.allclose(end[:, 1], (0.45, 0.6))


def test_a_walk_on_a_sphere_keeps_its_length(sphere):
    mesh = sphere(level=6)
    _, start = walked(mesh, np.array([[0.0, 0.1, 1.0]]), (0.0, 0.0, 0.0))
    _, end = walked(mesh, start, np.cross(start, (0.0, 1.0, 0.0)) * -0.8)
    angle = np.arccos(start[0] @ end[0] / np.linalg.norm(start) / np.linalg.norm(end))
    assert abs(angle - 0.8 * np.hypot(start[0, 0], start[0, 2])) < 0.01
