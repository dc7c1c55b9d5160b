"""The tree holds every triangle with an area once, and finds the closest point exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.geometry.simd import WIDTH, load, store
from hairpipe.geometry.triangle_tree import (
    LEAF,
    THINNEST,
    closest,
    closest_on_triangle,
    find_closest,
    halved,
    project,
    tree_over,
    wide_triangles,
)
from hairpipe.values import Mesh
from hairpipe.values.triangles import site_points


def soup(count: int) -> np.ndarray:
    rng = np.random.default_rng(count)
    return rng.normal(size=(count, 1, 3)) + 0.2 * rng.normal(size=(count, 3, 3))


@pytest.mark.parametrize("count", [1, 3, 4, 5, 37, 500])
def test_every_triangle_is_in_one_leaf(count):
    corners = soup(count)
    tree = tree_over(corners)
    assert np.array_equal(np.sort(tree.triangles), np.arange(count))
    assert np.array_equal(tree.corners, corners[tree.triangles])
    assert tree.starts[0] == 0 and tree.starts[-1] == count
    assert (np.diff(tree.starts) >= 0).all() and np.diff(tree.starts).max() <= LEAF


@pytest.mark.parametrize("count", [1, 5, 37, 500])
def test_boxes_are_as_tight_as_they_can_be(count):
    tree = tree_over(soup(count))
    leaves = len(tree.starts) - 1
    assert tree.boxes.shape == (2 * leaves, 2, 3)
    for box in range(1, 2 * leaves):
        first = last = box
        while first < leaves:
            first, last = 2 * first, 2 * last + 1
        below = tree.corners[tree.starts[first - leaves] : tree.starts[last - leaves + 1]].reshape(-1, 3)
        assert np.array_equal(tree.boxes[box, 0], below.min(axis=0, initial=np.inf))
        assert np.array_equal(tree.boxes[box, 1], below.max(axis=0, initial=-np.inf))


@pytest.mark.parametrize("count", [1, 5, 37, 500])
def test_every_box_is_halved_where_middles_spread_most(count):
    """Compared with a sort of each box by itself; of equal middles the first come first."""
    middles = np.round(np.random.default_rng(count).normal(size=(count, 3)), 1)
    leaves = 1 << int(np.ceil(np.log2(np.ceil(count / LEAF))))
    starts = count * np.arange(leaves + 1) // leaves

    def split(triangles, first, last):
        if last - first == 1:
            return triangles
        axis = np.argmax(np.ptp(middles[triangles], axis=0))
        triangles, middle = sorted(triangles, key=lambda t: middles[t, axis]), (first + last) // 2
        cut = starts[middle] - starts[first]
        return [*split(triangles[:cut], first, middle), *split(triangles[cut:], middle, last)]

    assert halved(middles, starts).tolist() == split(list(range(count)), 0, leaves)


def test_neighbours_lie_in_one_box(sphere):
    """A branch of n of the N triangles of a unit sphere covers n / N of its 4 pi, not all of it."""
    mesh = sphere(level=5)
    tree = tree_over(mesh.points[mesh.triangles])
    for level in range(2, 8):
        sizes = np.diff(tree.boxes[2**level : 2 ** (level + 1)], axis=1)
        assert np.linalg.norm(sizes, axis=-1).mean() < 2 * np.sqrt(4 * np.pi / 2**level)


def test_slivers_are_omitted(box):
    corners = box().points[box().triangles]
    corners[5, 2] = corners[5, 0] + 1e-9
    corners[7] = corners[7, 0]
    assert np.array_equal(wide_triangles(corners), np.delete(np.arange(12), (5, 7)))
    assert np.array_equal(np.sort(tree_over(corners).triangles), np.delete(np.arange(12), (5, 7)))


def test_a_body_without_area_is_refused(box):
    corners = box().points[box().triangles]
    corners[:, 2] = corners[:, 1]
    for flat in (corners, corners[:0], np.full((2, 3, 3), np.nan)):
        with pytest.raises(BadInput, match="no triangle has an area"):
            tree_over(flat)


coordinates = st.tuples(*[st.floats(-2, 2)] * 3)


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
    squared, weights = closest_on_triangle(corners[None], 0, tuple(point))
    assert np.sqrt(squared) == pytest.approx(by_projection(corners, point), abs=1e-7)
    assert min(weights) >= 0 and sum(weights) == pytest.approx(1, abs=1e-14)
    assert np.linalg.norm(point - weights @ corners) == pytest.approx(np.sqrt(squared), abs=1e-12)


def test_weights_are_never_negative_on_thin_triangles():
    """Points on the sides of triangles down to the thinnest, where rounding decides between side and corner."""
    rng = np.random.default_rng(0)
    for _ in range(20000):
        a, along, across = rng.normal(size=(3, 3))
        corners = np.stack([a, a + along, a + rng.uniform(-0.2, 1.2) * along + 10 ** rng.uniform(-6, 0) * across])
        k = rng.integers(3)
        point = corners[k] + 10 ** rng.uniform(-17, -12) * rng.normal(size=3)
        _, weights = closest_on_triangle(corners[None], 0, tuple(point))
        assert min(weights) >= 0 and sum(weights) == pytest.approx(1, abs=1e-14)


def test_weights_are_exactly_zero_outside_of_a_side():
    """Points beyond each side and each corner of random triangles, in their plane."""
    rng = np.random.default_rng(4)
    for corners in rng.normal(size=(200, 3, 3)):
        for k, (a, b, c) in enumerate(corners[[(i, i - 2, i - 1)]][0] for i in range(3)):
            out = (b + c) / 2 - a
            out -= out @ (c - b) / ((c - b) @ (c - b)) * (c - b)
            weights = closest_on_triangle(corners[None], 0, tuple(b + rng.uniform(0.1, 0.9) * (c - b) + out))[1]
            assert [w == 0.0 for w in weights] == [i == k for i in range(3)]
            away = (a - b) / np.linalg.norm(a - b) + (a - c) / np.linalg.norm(a - c)
            assert closest_on_triangle(corners[None], 0, tuple(a + away))[1] == tuple(np.eye(3)[k])


@pytest.mark.parametrize("count", [1, 3, 4, 5, 37, 500])
def test_a_soup_against_every_triangle(count):
    rng = np.random.default_rng(count)
    tree = tree_over(rng.normal(size=(count, 1, 3)) + 0.2 * rng.normal(size=(count, 3, 3)))
    for point in map(tuple, 2 * rng.normal(size=(200, 3))):
        squared, place, weights = closest(tree, point, np.inf, int(rng.integers(count)))
        assert squared == min(closest_on_triangle(tree.corners, other, point)[0] for other in range(count))
        assert closest_on_triangle(tree.corners, place, point) == (squared, weights)


@njit
def places_of_eight(tree, points, reach, guess, places):
    p = load(points, (0,)), load(points, (1,)), load(points, (2,))
    store(places, (0,), find_closest(tree, p, reach, guess))


@pytest.mark.parametrize("size", [0.01, 1.0])
@pytest.mark.parametrize("count", [1, 5, 37, 500])
def test_eight_points_at_once_against_every_triangle(count, size):
    """Points that are near each other, and such that are not; thin triangles too."""
    rng = np.random.default_rng(count)
    thin = 10 ** rng.uniform(-4, 0, (count, 1, 1)) * np.array([0.2, 0.2, 1e-3])
    tree = tree_over(rng.normal(size=(count, 1, 3)) + thin * rng.normal(size=(count, 3, 3)))
    for _ in range(50):
        points = rng.normal(size=(3, 1)) + size * rng.normal(size=(3, WIDTH))
        places = np.empty((1, WIDTH))
        places_of_eight(tree, points, np.inf, int(rng.integers(len(tree.triangles))), places)
        for place, point in zip(places[0].astype(int).tolist(), points.T, strict=True):
            found = [closest_on_triangle(tree.corners, other, tuple(point))[0] for other in range(len(tree.triangles))]
            assert found[place] == pytest.approx(min(found), rel=1e-9)


def test_beyond_reach_the_guess_answers(sphere):
    mesh = sphere(level=2)
    tree = tree_over(mesh.points[mesh.triangles])
    point = (3.0, 0.0, 0.0)
    assert closest(tree, point, 2.1**2, 0)[0] == pytest.approx(4.0)
    squared, place, weights = closest(tree, point, 1.9**2, 7)
    assert place == 7
    assert closest_on_triangle(tree.corners, 7, point) == (squared, weights)


@pytest.mark.parametrize("lost", [np.nan, np.inf, -np.inf])
def test_of_a_lost_point_the_guess_answers(sphere, lost):
    mesh = sphere(level=2)
    assert closest(tree_over(mesh.points[mesh.triangles]), (0.0, lost, 0.0), np.inf, 7)[1] == 7


def test_projections_lie_on_the_mesh_at_their_distance(sphere):
    mesh = sphere(level=4)
    points = np.random.default_rng(1).normal(size=(2000, 3))
    sites, distance = project(tree_over(mesh.points[mesh.triangles]), points)
    assert np.allclose(np.linalg.norm(site_points(mesh, sites) - points, axis=1), distance, atol=1e-14)
    assert (sites.barycentrics >= 0).all() and np.allclose(sites.barycentrics.sum(axis=1), 1, atol=1e-14)
    assert np.abs(distance - np.abs(np.linalg.norm(points, axis=1) - 1)).max() < 0.01


def test_projections_name_triangles_of_the_mesh_though_some_have_no_area():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 2, 2], [1, THINNEST / 4, 0.0]])
    mesh = Mesh(points, np.array([[3, 3, 3], [0, 1, 1], [0, 1, 4], [0, 1, 2]], np.int32))
    sites, distance = project(tree_over(points[mesh.triangles]), points[3:4] + 1)
    assert sites.triangles[0] == 3 and distance[0] == pytest.approx(np.linalg.norm([2.5, 2.5, 3.0]))


def test_projections_do_not_depend_on_threads(sphere, same_on_threads):
    mesh, points = sphere(level=3), np.random.default_rng(5).normal(size=(500, 3))
    same_on_threads(lambda: project(tree_over(mesh.points[mesh.triangles]), points))
