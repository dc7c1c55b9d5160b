"""Bodies whose holes are closed, so that hair knows what is inside."""

import numpy as np
import pytest

from hairpipe.geometry.solid import distance_and_normal, solid_of
from hairpipe.groom.growing import closed
from hairpipe.values import Mesh
from hairpipe.values.triangles import twin_corners


def without(mesh: Mesh, gone: np.ndarray) -> Mesh:
    """The mesh without the triangles that have a vertex among those."""
    return Mesh(mesh.points, mesh.triangles[~gone[mesh.triangles].any(axis=1)])


@pytest.mark.parametrize("flip", [False, True])
def test_points_are_inside_or_outside_of_a_ball_with_holes_as_of_a_whole_one(sphere, flip):
    whole = sphere(0.1, level=3)
    order = np.random.default_rng(0).permutation(len(whole.points)) if flip else np.arange(len(whole.points))
    whole = Mesh(whole.points[order], np.argsort(order).astype(np.int32)[whole.triangles])
    holes = (whole.points[:, 1] < -0.07) | (whole.points[:, 2] > 0.095)
    mesh = closed(without(whole, holes))
    assert (twin_corners(mesh.triangles) >= 0).all()
    solid = solid_of(mesh)
    around = [(0.0, -0.2, 0.0), (0.05, -0.3, 0.0), (0.0, -0.08, 0.09), (0.09, -0.09, 0.0), (0.0, 0.0, 0.12)]
    assert all(distance_and_normal(solid, point, 0)[0] > 0.0 for point in around)
    assert all(distance_and_normal(solid, point, 0)[0] < 0.0 for point in [(0.0, 0.0, 0.0), (0.0, -0.06, 0.0)])


def test_a_whole_body_and_a_sheet_stay_as_they_are(sphere, sheet):
    for mesh in (sphere(0.1, level=2), sheet(4, 4)):
        assert closed(mesh) is mesh
