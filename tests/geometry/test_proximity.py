"""Every pair of segments within reach is found, and of every segment the closest few."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.proximity import CROSS, approaches, closest_pairs, near_pairs
from hairpipe.geometry.segment_distance import closest_of, closest_on_segments
from hairpipe.geometry.segments import empty_pairs, key_of, within

from ..segment_scenes import distances_of, every_pair

ROUNDING = 1e-9


def keys(pairs):
    return set(key_of(np.asarray(pairs)).tolist())


def test_none_missing_none_extra(scene):
    points, offsets, reach = scene
    i, j = every_pair(offsets)
    distances = distances_of(points, i, j)
    all_pairs, blur = np.stack([i, j], axis=1), ROUNDING * np.abs(points).max()
    found = near_pairs(points, offsets, reach)
    assert keys(all_pairs[distances <= reach - blur]) <= keys(found.segments)
    assert keys(found.segments) <= keys(all_pairs[distances <= reach + blur])
    assert (np.diff(key_of(found.segments)) > 0).all()
    assert (found.distances <= reach).all()
    order = np.searchsorted(key_of(all_pairs), key_of(found.segments))
    np.testing.assert_allclose(found.distances, distances[order], atol=blur)


def test_fractions_are_where_the_distance_is(scene):
    points, offsets, reach = scene
    found = near_pairs(points, offsets, reach)
    i, j = found.segments.T
    s, t = found.fractions.T[:, :, None]
    gap = (1 - s) * points[i] + s * points[i + 1] - (1 - t) * points[j] - t * points[j + 1]
    np.testing.assert_allclose(np.linalg.norm(gap, axis=1), found.distances, atol=ROUNDING * np.abs(points).max())


def test_ignored_pairs_are_excluded(scene):
    points, offsets, reach = scene
    everything = key_of(near_pairs(points, offsets, reach).segments)
    ignored = np.sort(np.concatenate([everything[::2], [0, 1 << 40]]))
    np.testing.assert_array_equal(key_of(near_pairs(points, offsets, reach, ignored).segments), everything[1::2])


def test_more_pairs_than_room_was_made_for():
    """Eight hundred segments in one place: half a million pairs from one chunk."""
    points = np.zeros((1600, 3))
    points[1::2, 0] = 1.0
    found = near_pairs(points, np.arange(801, dtype=np.int32) * 2, 0.1)
    assert len(found.distances) == 800 * 799 // 2
    assert (np.diff(key_of(found.segments)) > 0).all()


def test_threads_do_not_matter(hair, same_on_threads):
    points, _, offsets = hair
    near = same_on_threads(lambda: near_pairs(points, offsets, 5e-3))
    assert len(near.distances) > 1000
    assert len(same_on_threads(lambda: closest(points, near, 3)).distances) > 1000


@pytest.mark.parametrize("offsets", [[0], [0, 0], [0, 1], [0, 1, 2], [0, 2], [0, 0, 3, 3]])
def test_hair_with_no_pairs(offsets):
    points = np.random.default_rng(0).random((offsets[-1], 3))
    found = near_pairs(points, np.array(offsets, np.int32), 10.0)
    for field, empty in zip(found, empty_pairs(), strict=True):
        assert (field.shape, field.dtype) == (empty.shape, empty.dtype)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e13])
def test_positions_that_are_not_finite_are_refused(scene, value):
    points, offsets, reach = scene
    points = points.copy()
    points[7, 1] = value
    with pytest.raises(ArithmeticError, match="number 7"):
        near_pairs(points, offsets, reach)


def every(pairs):
    return np.ones(len(pairs.distances), bool)


def test_approaches_are_the_near_pairs_that_have_no_nearer_neighbour(scene):
    points, offsets, reach = scene
    near = near_pairs(points, offsets, reach)
    distances = dict(zip(map(tuple, near.segments.tolist()), near.distances.tolist(), strict=True))
    fractions = dict(zip(distances, near.fractions[:, 0].tolist(), strict=True))
    nearest = {
        (i, j): distance
        for (i, j), distance in distances.items()
        if not (distances.get((i, j - 1), np.inf) <= distance or distances.get((i, j + 1), np.inf) < distance)
    }

    def is_corner(i, j):
        """Whether the pair crosses at an end of the first segment, beyond which the next is nearer."""
        u, v = points[i + 1] - points[i], points[j + 1] - points[j]
        # Sums in order, as the kernel has them: the scenes have ties, and u @ u rounds as the processor does.
        if np.sum(np.cross(u, v) ** 2) <= CROSS * np.sum(u * u) * np.sum(v * v):
            return False
        before, after = nearest.get((i - 1, j), np.inf), nearest.get((i + 1, j), np.inf)
        at, distance = fractions[i, j], nearest[i, j]
        return (at == 0.0 and before <= distance) or (at == 1.0 and after < distance)

    expected = [pair for pair in nearest if not is_corner(*pair)]
    found = approaches(near, every(near), points)
    assert [tuple(pair) for pair in found.segments.tolist()] == expected


def lines(*strands):
    return np.concatenate(strands), np.cumsum([0, *map(len, strands)]).astype(np.int32)


@pytest.mark.parametrize("joint", ["first", "second"])
@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_a_strand_across_a_joint_approaches_it_once(joint, shift):
    along = np.linspace(-1.0, 1.0, 5)[:, None] * [0.0, 0.0, 1.0]
    across = np.array([[-0.3, 0.1, shift], [0.3, 0.1, shift]])
    points, offsets = lines(*((along, across) if joint == "first" else (across, along)))
    near = near_pairs(points, offsets, 0.2)
    assert len(near.distances) == 2
    assert len(approaches(near, every(near), points).distances) == 1


@pytest.mark.parametrize("shift", [0.0, 0.013, 0.05, 0.087])
def test_a_strand_along_another_approaches_it_with_every_segment(shift):
    one = np.linspace(0.0, 1.0, 11)[:, None] * [0.0, 0.0, 1.0]
    points, offsets = lines(one, one + np.array([0.001, 0.0, shift]))
    near = near_pairs(points, offsets, 0.002)
    assert len(near.distances) >= 18
    found = approaches(near, every(near), points)
    np.testing.assert_array_equal(np.unique(found.segments[:, 0]), np.arange(10))
    assert len(found.distances) <= 12


def test_every_turn_of_a_coil_is_approached():
    turns = np.linspace(0.0, 3.0, 61)[:, None]
    coil = np.concatenate([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns), 0.01 * turns], axis=1)
    near = near_pairs(coil, np.array([0, 61], np.int32), 0.025)
    found = approaches(near, every(near), coil)
    first = found.segments[found.segments[:, 0] == 5, 1]
    assert np.any(abs(first - 25) <= 1) and np.any(abs(first - 45) <= 1)


def test_of_near_pairs_those_nearer_and_not_ignored_are_marked(scene):
    points, offsets, reach = scene
    everything = near_pairs(points, offsets, reach)
    ignored = key_of(everything.segments)[::3]
    expected = near_pairs(points, offsets, 0.6 * reach, ignored)
    marked = within(everything, len(points), 0.6 * reach, ignored)
    for found, wanted in zip(everything, expected, strict=True):
        np.testing.assert_array_equal(found[marked], wanted)
    for found, wanted in zip(
        approaches(everything, marked, points), approaches(expected, every(expected), points), strict=True
    ):
        np.testing.assert_array_equal(found, wanted)


@njit
def _squared_distances(points, pairs, out):
    for k in range(len(pairs)):
        out[k] = closest_of(points, pairs[k, 0], pairs[k, 1])[2]


def closest(points, pairs, most, room=None):
    """Of all pairs."""
    return closest_pairs(points, pairs, np.ones(len(pairs.distances), bool), most, room)


def chosen_among(points, pairs, limits):
    """Sort all that is near by distance, then number, and keep the pairs that are in both lists."""
    pairs = pairs[(limits[pairs] > 0).all(axis=1)]
    squared, lists = np.empty(len(pairs)), {}
    _squared_distances(points, pairs, squared)
    for (i, j), d in zip(pairs.tolist(), squared.tolist(), strict=True):
        lists.setdefault(i, []).append((d, j))
        lists.setdefault(j, []).append((d, i))
    lists = {i: {j for _, j in sorted(near)[: limits[i]]} for i, near in lists.items()}
    return [[i, j] for i, j in pairs.tolist() if j in lists[i] and i in lists[j]]


@pytest.mark.parametrize("most", [1, 5])
def test_the_closest_of_both(scene, most):
    points, offsets, reach = scene
    expected = chosen_among(points, near_pairs(points, offsets, reach).segments, np.full(len(points), most))
    found = closest(points, near_pairs(points, offsets, reach), most)
    assert found.segments.tolist() == expected
    assert np.bincount(found.segments.ravel()).max() <= most


def test_room_that_is_left(scene):
    points, offsets, reach = scene
    room = np.random.default_rng(6).integers(0, 7, len(points))
    expected = chosen_among(points, near_pairs(points, offsets, reach).segments, np.minimum(room, 4))
    found = closest(points, near_pairs(points, offsets, reach), 4, room)
    assert found.segments.tolist() == expected
    assert (np.bincount(found.segments.ravel(), minlength=len(points)) <= room).all()


def test_ignored_segments_take_no_place(scene):
    points, offsets, reach = scene
    ignored = key_of(closest(points, near_pairs(points, offsets, reach), 2).segments)
    others = near_pairs(points, offsets, reach, ignored)
    found = closest(points, others, 2)
    assert found.segments.tolist() == chosen_among(points, others.segments, np.full(len(points), 2))


@njit
def _all(points, out):
    for k in range(len(out)):
        out[k] = closest_of(points, 4 * k, 4 * k + 2)


def of(*points):
    return closest_on_segments(*(tuple(map(float, p)) for p in points))


def test_no_other_places_are_closer():
    """Nearly parallel, coplanar, touching and short ones, beside independent formulas; a hundred thousand of them."""
    rng = np.random.default_rng(1)
    points = rng.normal(size=(100_000, 4, 3))
    points[::4] = np.round(2 * points[::4]) / 2
    angles = 10.0 ** rng.uniform(-16, -1, (25_000, 1))
    points[1::4, 3] = points[1::4, 2] + rng.normal(size=(25_000, 1)) * (points[1::4, 1] - points[1::4, 0])
    points[1::4, 3] += angles * rng.normal(size=(25_000, 3))
    points[2::4, 1] = points[2::4, 0] + angles * rng.normal(size=(25_000, 3))
    flat = points.reshape(-1, 3)
    found = np.empty((len(points), 3))
    _all(flat, found)
    first = 4 * np.arange(len(points))
    expected = distances_of(flat, first, first + 2)
    np.testing.assert_allclose(np.sqrt(found[:, 2]), expected, atol=2e-14)
    assert ((found[:, :2] >= 0) & (found[:, :2] <= 1)).all()


def test_parallel_ones_are_closest_in_the_middle_of_their_overlap():
    u = np.array([0.1, 0.7, -0.3])
    n = np.array([0.7, -0.1, 0.0])
    s, t, squared = of(0 * u, u, 0.5 * u + n, 2 * u + n)
    assert (s, t, squared) == pytest.approx((0.75, 1 / 6, n @ n))
    assert of(0 * u, u, 2 * u + n, 0.5 * u + n)[:2] == pytest.approx((0.75, 5 / 6))
    assert of(0 * u, u, 3 * u, 2 * u) == pytest.approx((1, 1, u @ u))


def test_coincident_and_without_length():
    a, b = np.array([0.2, 0.3, 0.1]), np.array([1.0, 0.0, 0.4])
    assert of(a, b, a, b) == pytest.approx((0.5, 0.5, 0.0))
    assert of(a, a, a, a)[2] == 0.0
    assert of(a, a, b, b)[2] == pytest.approx((a - b) @ (a - b))
    assert of((0, 1, 0), (0, 1, 0), (-1, 0, 0), (3, 0, 0))[1:] == pytest.approx((0.25, 1.0))
    assert of((-1, 0, 0), (3, 0, 0), (0, 1, 0), (0, 1, 0))[::2] == pytest.approx((0.25, 1.0))
