"""A mesh is made a closed surface, or refused with the reason."""

import warnings

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.levelset.closed_surface import closed_surface
from hairpipe.values import Mesh


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


def test_crowded_edges_are_reported(box, together):
    fins = together(box(), box((0.5, -0.5, -0.5), (1.5, 0.5, 0.5)))
    with pytest.warns(UserWarning, match="5 edges have more than two triangles"):
        points, same = np.unique(fins.points, axis=0, return_inverse=True)
        closed_surface(Mesh(points, same.reshape(-1)[fins.triangles].astype(np.int32)), "refuse")
