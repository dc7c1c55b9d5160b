"""The closest point is found exactly, among any triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from hairpipe.levelset.closest import closest, closest_on_triangle
from hairpipe.levelset.surface import Surface
from hairpipe.levelset.tree import tree_over

coordinates = st.tuples(*[st.floats(-2, 2)] * 3)


def search(tree, point, reach=np.inf, guess=0):
    return closest(tree, *point, reach, guess, np.empty(64, np.int64), np.empty(64))


def by_projection(corners: np.ndarray, point: np.ndarray) -> float:
    """Distance to a triangle as the least of those to its face and its sides, each found on its own."""
    a, b, c = corners
    within = []
    for p, q in ((a, b), (b, c), (c, a)):
        t = np.clip((point - p) @ (q - p) / max((q - p) @ (q - p), 1e-300), 0, 1)
        within.append(np.linalg.norm(point - p - t * (q - p)))
    s, r = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), point - a, rcond=None)[0]
    if s >= 0 and r >= 0 and s + r <= 1:
        within.append(np.linalg.norm(point - a - s * (b - a) - r * (c - a)))
    return min(within)


@settings(deadline=None)
@given(st.tuples(coordinates, coordinates, coordinates), coordinates)
def test_a_triangle(corners, point):
    corners, point = np.array(corners), np.array(point)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    if np.linalg.norm(normal) < 1e-4:
        return
    squared, s, r = closest_on_triangle(corners[None], 0, *point)
    assert np.sqrt(squared) == pytest.approx(by_projection(corners, point), abs=1e-7)
    assert s >= 0 and r >= 0 and s + r <= 1 + 1e-12
    reached = corners[0] + s * (corners[1] - corners[0]) + r * (corners[2] - corners[0])
    assert np.linalg.norm(point - reached) == pytest.approx(np.sqrt(squared), abs=1e-12)


def test_a_triangle_against_an_optimiser():
    rng = np.random.default_rng(3)
    for _ in range(20):
        corners, point = rng.normal(size=(3, 3)), 2 * rng.normal(size=3)
        bounds = {"type": "ineq", "fun": lambda w: [w[0], w[1], 1 - w[0] - w[1]]}
        sides = corners[1:] - corners[0]
        found = minimize(lambda w: ((point - corners[0] - w @ sides) ** 2).sum(), [0.3, 0.3], constraints=bounds)  # noqa: B023
        assert closest_on_triangle(corners[None], 0, *point)[0] == pytest.approx(found.fun, abs=1e-5)


@pytest.mark.parametrize("count", [1, 3, 4, 5, 37, 500])
def test_a_soup_against_every_triangle(count):
    rng = np.random.default_rng(count)
    corners = rng.normal(size=(count, 1, 3)) + 0.2 * rng.normal(size=(count, 3, 3))
    tree = tree_over(Surface(corners, np.zeros_like(corners)))
    for point in 2 * rng.normal(size=(200, 3)):
        squared, t, s, r = search(tree, point, guess=int(rng.integers(count)))
        assert squared == min(closest_on_triangle(tree.corners, other, *point)[0] for other in range(count))
        a, b, c = tree.corners[t]
        assert np.linalg.norm(point - a - s * (b - a) - r * (c - a)) == pytest.approx(np.sqrt(squared), abs=1e-12)


def test_the_tree_keeps_every_triangle_with_its_velocity(sphere):
    corners = sphere(level=2).points[sphere(level=2).triangles]
    tree = tree_over(Surface(corners, 3 * corners))
    assert sorted(map(tuple, tree.corners.reshape(-1, 9))) == sorted(map(tuple, corners.reshape(-1, 9)))
    assert np.array_equal(tree.velocities, 3 * tree.corners)


def test_beyond_reach_the_guess_answers(sphere):
    corners = sphere(level=2).points[sphere(level=2).triangles]
    tree = tree_over(Surface(corners, corners))
    point = np.array([3.0, 0.0, 0.0])
    assert search(tree, point, reach=2.1**2)[0] == pytest.approx(4.0)
    squared, t, *_ = search(tree, point, reach=1.9**2, guess=7)
    assert t == 7
    assert squared == closest_on_triangle(tree.corners, 7, *point)[0]
