"""Limit points of subdivision surfaces, against repeated refinement that follows the definition."""

import warnings

import numpy as np
import pytest

from hairpipe.formats.polygons import limit_points, warn_of_cage

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
