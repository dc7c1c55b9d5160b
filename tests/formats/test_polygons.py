import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.formats.polygons import newell_normal, triangulate

TURN = Rotation.from_euler("xyz", [30.0, -50.0, 110.0], degrees=True).as_matrix()
SHAPES = {
    "triangle": [(0, 0), (2, 0), (0, 1)],
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "dart": [(0, 0), (4, -2), (1, 0), (4, 2)],
    "dart from its tip": [(4, 2), (0, 0), (4, -2), (1, 0)],
    "ell": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)],
    "comb": [(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)],
    "hexagon": [(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3],
}


def lift(shape) -> np.ndarray:
    return np.column_stack([np.array(shape, float), np.zeros(len(shape))]) @ TURN.T + (1.0, 2.0, 3.0)


def shoelace(shape) -> float:
    x, y = np.array(shape, float).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_fill_the_polygon_exactly_and_face_as_it_does(name):
    corners = lift(SHAPES[name])
    triangles = corners[triangulate(corners, np.array([len(corners)]))]
    areas = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) @ TURN[:, 2]
    assert len(triangles) == len(corners) - 2
    assert (areas >= -1e-12).all()  # none turned over: nothing is covered twice
    assert areas.sum() == pytest.approx(shoelace(SHAPES[name]))


def test_polygons_of_any_size_stay_in_order():
    shapes = [SHAPES[name] for name in ("square", "triangle", "ell", "square")]
    corners = np.concatenate([lift(shape) for shape in shapes])
    triangles = triangulate(corners, np.array([4, 3, 6, 4]))
    owner = np.repeat(np.arange(4), [4, 3, 6, 4])[triangles]
    np.testing.assert_array_equal(owner[:, 0], [0, 0, 1, 2, 2, 2, 2, 3, 3])
    assert (owner == owner[:, :1]).all()


def test_newell_normal_is_the_area_vector():
    np.testing.assert_allclose(newell_normal(lift(SHAPES["comb"])), shoelace(SHAPES["comb"]) * TURN[:, 2], atol=1e-12)


@pytest.mark.parametrize("shape", [[(0, 0)] * 5, [(0, 0), (1, 1), (0, 1), (1, 0)], [(0, 0), (1, 0), (2, 0), (3, 0)]])
def test_degenerate_polygons_end_too(shape):
    assert triangulate(lift(shape), np.array([len(shape)])).shape == (len(shape) - 2, 3)


def test_many_warped_and_concave_quads_are_cut_at_once():
    corners = np.random.default_rng(2).normal(size=(100_000, 4, 3))
    begun = time.process_time()
    triangles = triangulate(corners.reshape(-1, 3), np.full(len(corners), 4)).reshape(-1, 2, 3)
    assert time.process_time() - begun < 5.0  # seconds; polygon by polygon it takes 16
    alone = [triangulate(quad, np.array([4])) for quad in corners[:50]]
    np.testing.assert_array_equal(triangles[:50] - 4 * np.arange(50)[:, None, None], alone)
