"""Polygons become triangles; cages of subdivision surfaces have limit points."""

import time
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.formats.polygons import limit_points, newell_normal, triangulate, warn_of_cage

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


CUBE = np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
PRISM = np.array([[np.cos(a), y, np.sin(a)] for y in (0.0, 1.5) for a in 2 * np.pi * np.arange(5) / 5])
PRISM_SIDES = [(4, 3, 2, 1, 0), (5, 6, 7, 8, 9), *((k, (k + 1) % 5, 5 + (k + 1) % 5, 5 + k) for k in range(5))]


def refined(points: np.ndarray, faces: list[tuple[int, ...]]) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Refine a closed or open mesh once by the rules of Catmull and Clark (1978); old vertices come first."""
    centres = [points[list(face)].mean(axis=0) for face in faces]
    sides: dict[tuple[int, int], list[int]] = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            sides.setdefault((min(a, b), max(a, b)), []).append(f)
    middle = {e: points[list(e)].mean(axis=0) for e in sides}
    edge = {
        e: middle[e] if len(f) == 1 else (2 * middle[e] + centres[f[0]] + centres[f[1]]) / 4 for e, f in sides.items()
    }
    moved = []
    for v, point in enumerate(points):
        own = [e for e in sides if v in e]
        rim = [e for e in own if len(sides[e]) == 1]
        n = len(own)
        if rim:
            moved.append((middle[rim[0]] + middle[rim[1]] + 2 * point) / 4)
        else:
            around = np.mean([centres[f] for f, face in enumerate(faces) if v in face], axis=0)
            moved.append((around + 2 * np.mean([middle[e] for e in own], axis=0) + (n - 3) * point) / n)
    place = {e: len(points) + k for k, e in enumerate(sides)}
    first = len(points) + len(sides)
    quads = []
    for f, face in enumerate(faces):
        for before, v, after in zip((face[-1], *face[:-1]), face, (*face[1:], face[0]), strict=True):
            edges = [place[min(v, w), max(v, w)] for w in (after, before)]
            quads.append((v, edges[0], first + f, edges[1]))
    return np.array([*moved, *edge.values(), *centres]), quads


@pytest.mark.parametrize(
    ("points", "faces"),
    [(CUBE, SIDES), (PRISM, PRISM_SIDES), (CUBE, SIDES[1:])],
    ids=["cube", "prism of pentagons", "open box"],
)
def test_limit_points_are_those_of_repeated_refinement(points, faces):
    sizes, corners = np.array([len(face) for face in faces]), np.concatenate(faces)
    expected, polygons = points, faces
    for _ in range(4):
        expected, polygons = refined(expected, polygons)
    limit = limit_points(points, sizes, corners, "catmullClark")
    np.testing.assert_allclose(limit, expected[: len(points)], atol=5e-3 * np.abs(points).max())


def test_the_loop_limit_of_a_tetrahedron_follows_loops_mask():
    """By Loop's mask for valence 3, beta = 3/16, the weight of each neighbour is 1/5."""
    corners = np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]]) - 0.5
    faces = np.array([0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2])
    limit = limit_points(corners, np.full(4, 3), faces, "loop")
    np.testing.assert_allclose(limit, corners * (2 / 5 - 1 / 5), atol=1e-12)


def test_a_coarse_cage_is_named_and_a_fine_one_is_not():
    corners, sizes = np.concatenate(SIDES), np.full(6, 4)
    with pytest.warns(UserWarning, match="a /box is a subdivision surface .catmullClark., .* 43 %"):
        warn_of_cage("a /box", CUBE, sizes, corners, "catmullClark")
    points, faces = CUBE, SIDES
    for _ in range(4):
        points, faces = refined(points, faces)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_cage("a /box", points, np.full(len(faces), 4), np.concatenate(faces), "catmullClark")
