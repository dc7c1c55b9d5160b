"""A mesh is made a closed surface, holes as loops, or refused with the reason."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hairpipe.errors import BadInput
from hairpipe.levelset.closed_surface import capped, closed_surface, describe, edge_uses, holes
from hairpipe.values import Mesh

from ..conftest import together


def broken(mesh: Mesh, **changes) -> Mesh:
    arrays = {"points": mesh.points.copy(), "triangles": mesh.triangles.copy(), "velocities": mesh.points * 0.0}
    for name, (place, value) in changes.items():
        arrays[name][place] = value
    return Mesh(**arrays)


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ({"points": ((3, 1), np.nan)}, r"point 3 is \(.*nan"),
        ({"points": ((0, 0), np.inf)}, r"point 0 is \(inf"),
        ({"points": ((0, 0), 1e300)}, r"point 0 is \(1e\+300"),
        ({"velocities": ((5, 2), np.nan)}, r"velocity of point 5"),
        ({"triangles": ((2, 0), 8)}, r"triangle 2 names points \[8.*0 to 7"),
        ({"triangles": ((7, 1), -1)}, r"triangle 7 names points"),
        ({"triangles": (slice(None), 4)}, r"no triangle has an area"),
        ({"points": (slice(None), 0.25)}, r"no triangle has an area"),
    ],
)
def test_invalid_surfaces_are_refused(box, changes, reported):
    with pytest.raises(BadInput, match=reported):
        closed_surface(broken(box(), **changes), "fill")


def test_nothing_is_refused(box):
    mesh = box()
    for empty in (Mesh(mesh.points[:0], mesh.triangles[:0]), Mesh(mesh.points, mesh.triangles[:0])):
        with pytest.raises(BadInput, match="the mesh is empty"):
            closed_surface(empty, "fill")


def test_velocities_must_be_one_a_point(box):
    mesh = box()
    with pytest.raises(BadInput, match=r"7 velocities.*each of the 8 points"):
        closed_surface(Mesh(mesh.points, mesh.triangles, mesh.points[:7]), "fill")


def test_holes_are_refused_or_capped_with_a_warning(box):
    mesh = Mesh(box().points, box().triangles[2:])
    with pytest.raises(BadInput, match=r"open: 1 hole: 4 edges, 4 m around, at \(-0.500, 0.000, 0.000\)"):
        closed_surface(mesh, "refuse")
    with pytest.warns(UserWarning, match="capped 1 hole: 4 edges"):
        assert len(closed_surface(mesh, "fill").corners) == 10 + 4


def test_a_surface_split_along_seams_is_closed(box):
    mesh = box()
    apart = Mesh(mesh.points[mesh.triangles].reshape(-1, 3), np.arange(36, dtype=np.int32).reshape(-1, 3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(closed_surface(apart, "refuse").corners) == 12


def test_a_body_at_rest_has_velocity_zero(box):
    assert not closed_surface(box(), "refuse").velocities.any()


def test_crowded_edges_are_reported(box):
    fins = together(box(), box((0.5, -0.5, -0.5), (1.5, 0.5, 0.5)))
    with pytest.warns(UserWarning, match="5 edges have more than two triangles"):
        points, same = np.unique(fins.points, axis=0, return_inverse=True)
        closed_surface(Mesh(points, same.reshape(-1)[fins.triangles].astype(np.int32)), "refuse")


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
