"""Bodies of known shape are closed, outward and of the right size."""

import numpy as np
import pytest

from hairpipe.body.shapes import build_box, build_cylinder, join
from hairpipe.errors import BadInput
from hairpipe.geometry.solid import distance_and_normal, solid_of
from hairpipe.values import Mesh
from hairpipe.values.triangles import area_vectors, twin_corners

CENTRE, ALONG = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, -0.5])
SHAPES = {
    "ball": (build_cylinder(0.05, 0.0, True, 96, tuple(CENTRE), tuple(ALONG)), 4 / 3 * np.pi * 0.05**3),
    "capsule": (
        build_cylinder(0.05, 0.2, True, 96, tuple(CENTRE), tuple(ALONG)),
        np.pi * 0.05**2 * (0.2 + 4 / 3 * 0.05),
    ),
    "cylinder": (build_cylinder(0.05, 0.2, False, 96, tuple(CENTRE), tuple(ALONG)), np.pi * 0.05**2 * 0.2),
    "box": (build_box((0.1, 0.2, 0.3), tuple(CENTRE)), 0.006),
}


@pytest.mark.parametrize("name", SHAPES)
def test_it_is_closed_outward_and_of_the_right_volume(name):
    mesh, volume = SHAPES[name]
    assert (twin_corners(mesh.triangles) >= 0).all()
    assert (np.linalg.norm(area_vectors(mesh), axis=1) > 1e-12).all()
    found = np.sum(area_vectors(mesh) * (mesh.points[mesh.triangles[:, 0]] - CENTRE)) / 3
    assert found == pytest.approx(volume, rel=3e-3)
    assert len(np.unique(mesh.triangles)) == len(mesh.points)


@pytest.mark.parametrize(("name", "length"), [("ball", 0.0), ("capsule", 0.2), ("cylinder", 0.2)])
def test_its_distance_is_that_of_the_shape(name, length):
    solid, axis = solid_of(SHAPES[name][0]), ALONG / np.linalg.norm(ALONG)
    for point in np.random.default_rng(1).uniform(-0.2, 0.2, (200, 3)):
        height, z = np.linalg.norm(point - (point @ axis) * axis), point @ axis
        beyond = np.array([height - 0.05, abs(z) - length / 2])
        if name == "cylinder":
            expected = np.linalg.norm(np.maximum(beyond, 0)) + min(beyond.max(), 0)
        else:
            expected = np.hypot(height, max(beyond[1], 0)) - 0.05
        found, _, _ = distance_and_normal(solid, tuple(point + CENTRE), 0)
        assert found == pytest.approx(expected, abs=6e-5)


def test_joined_meshes_keep_their_places_and_velocities():
    still, speeds = SHAPES["box"][0], np.random.default_rng(2).normal(size=(8, 3))
    moving = Mesh(still.points + 1.0, still.triangles, speeds)
    both = join((still, moving))
    assert join((still, still)).velocities is None and both.velocities is not None
    np.testing.assert_array_equal(both.velocities, np.concatenate([np.zeros((8, 3)), speeds]))
    np.testing.assert_array_equal(both.points[both.triangles[12:]], moving.points[moving.triangles])


def test_joined_meshes_keep_their_texture_coordinates():
    bare = SHAPES["box"][0]
    uv = np.random.default_rng(3).random((12, 3, 2)).astype(np.float32)
    both = join((bare, Mesh(bare.points, bare.triangles, uv=uv)))
    assert join((bare, bare)).uv is None and both.uv is not None and both.uv.dtype == np.float32
    np.testing.assert_array_equal(both.uv, np.concatenate([0 * uv, uv]))


def test_degenerate_shapes_are_refused():
    with pytest.raises(BadInput, match="no length"):
        build_cylinder(0.05, 0.2, False, 96, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    with pytest.raises(BadInput, match="flat ends"):
        build_cylinder(0.05, 0.0, False, 96, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
