"""Holes are found as loops, whatever the mesh, and capping closes them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hairpipe.levelset.closed_surface import capped, describe, edge_uses, holes
from hairpipe.values import Mesh


def open_edges(mesh: Mesh) -> np.ndarray:
    edges, uses = edge_uses(mesh.triangles)
    return edges[uses % 2 == 1]


def moving(mesh: Mesh) -> Mesh:
    return Mesh(mesh.points, mesh.triangles, np.cross([0.0, 0.0, 2.0], mesh.points))


def test_a_closed_mesh_has_none(sphere):
    assert holes(open_edges(sphere()), sphere().points) == []


def test_a_missing_face_is_one_hole(box):
    mesh = moving(box())
    opened = Mesh(mesh.points, mesh.triangles[2:], mesh.velocities)
    (hole,) = holes(open_edges(opened), opened.points)
    assert set(hole.loop) == {0, 1, 2, 3}
    assert np.isclose(hole.length, 4)
    assert np.allclose(hole.centre, [-0.5, 0, 0])
    closed = capped(opened, [hole])
    assert len(open_edges(closed)) == 0
    assert np.allclose(closed.velocities[-1], np.cross([0, 0, 2.0], hole.centre))


def test_holes_that_meet_at_a_point_are_two(sphere):
    mesh = sphere(level=1)
    top = np.flatnonzero((mesh.triangles == 2).any(axis=1))
    opposite = next(t for t in top[1:] if len({*mesh.triangles[top[0]], *mesh.triangles[t]}) == 5)
    kept = np.delete(mesh.triangles, [top[0], opposite], axis=0)
    found = holes(open_edges(Mesh(mesh.points, kept)), mesh.points)
    assert [len(hole.loop) for hole in found] == [3, 3]
    assert "2 holes: 3 edges" in describe(found)


@given(st.sets(st.integers(0, 127), min_size=1))
def test_any_triangles_taken_away_leave_loops_that_capping_closes(sphere, gone):
    mesh = moving(sphere(level=2))
    kept = np.delete(mesh.triangles, sorted(gone), axis=0)
    if len(kept) == 0:
        return
    opened = Mesh(mesh.points, kept, mesh.velocities)
    found = holes(open_edges(opened), opened.points)
    assert sum(len(hole.loop) for hole in found) == len(open_edges(opened))
    assert all(len(set(hole.loop)) == len(hole.loop) for hole in found)
    assert len(open_edges(capped(opened, found))) == 0


@given(st.lists(st.tuples(*[st.integers(0, 7)] * 3), min_size=1, max_size=30))
def test_any_soup_of_triangles_is_closed_by_capping(soup):
    points = np.random.default_rng(0).random((8, 3))
    mesh = Mesh(points, np.array(soup, np.int32), np.zeros((8, 3)))
    assert len(open_edges(capped(mesh, holes(open_edges(mesh), points)))) == 0
