"""The tree holds every triangle with an area once, and its boxes hold what lies below them."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import LEAF, halved, tree_over, wide_triangles


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
