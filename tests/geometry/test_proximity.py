"""Every pair of segments within reach is found, and of every segment the closest few."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.proximity import CROSS, FARTHER, approaches, closest_pairs, near_pairs
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


def part_of(distances, pair, way):
    """Part of a pair among those one and two steps along a way, up to the first that is not near."""
    own, near = distances[pair], []
    for side in (-1, 1):
        for step in (side, 2 * side):
            beside = pair[0] + step * way[0], pair[1] + step * way[1]
            if beside not in distances:
                break
            near.append(distances[beside])
    least = min([own, *near])
    left = [max(FARTHER * least - (d - least), 0.0) ** 2 if least else float(d == least) for d in (own, *near)]
    return left[0] / sum(left)


def test_shares_are_those_of_the_five_pairs_in_a_row(scene):
    points, offsets, reach = scene
    near = near_pairs(points, offsets, reach)
    distances = dict(zip(map(tuple, near.segments.tolist()), near.distances.tolist(), strict=True))
    expected = {}
    for i, j in distances:
        u, v = points[i + 1] - points[i], points[j + 1] - points[j]
        # Sums in order, as the kernel has them: u @ u rounds as the processor does.
        area, whole = np.sum(np.cross(u, v) ** 2), np.sum(u * u) * np.sum(v * v)
        part = np.clip((area / whole - CROSS[0]) / (CROSS[1] - CROSS[0]), 0.0, 1.0) if whole > 0.0 else 0.0
        crossing = part * part * (3.0 - 2.0 * part)
        along, across = part_of(distances, (i, j), (0, 1)), part_of(distances, (i, j), (1, 0))
        expected[i, j] = along * (1.0 - crossing * (1.0 - across))
    found, shares = approaches(near, every(near), points)
    got = dict(zip(map(tuple, found.segments.tolist()), shares.tolist(), strict=True))
    assert got.keys() <= expected.keys() and (shares > 0.0).all()
    for pair, share in expected.items():
        assert got.get(pair, 0.0) == pytest.approx(share, abs=1e-9)


def lines(*strands):
    return np.concatenate(strands), np.cumsum([0, *map(len, strands)]).astype(np.int32)


@pytest.mark.parametrize("joint", ["first", "second"])
def test_a_strand_across_a_joint_has_one_contact_that_passes_on_without_a_jump(joint):
    along, had = np.linspace(-1.0, 1.0, 5)[:, None] * [0.0, 0.0, 1.0], None
    for shift in np.linspace(-0.12, 0.12, 961):
        across = np.array([[-0.3, 0.1, shift], [0.3, 0.1, shift]])
        points, offsets = lines(*((along, across) if joint == "first" else (across, along)))
        near = near_pairs(points, offsets, 0.2)
        found, shares = approaches(near, every(near), points)
        assert shares.sum() == pytest.approx(1.0)
        now = {tuple(pair): share for pair, share in zip(found.segments.tolist(), shares.tolist(), strict=True)}
        if had is not None:
            assert max(abs(now.get(pair, 0.0) - had.get(pair, 0.0)) for pair in now.keys() | had.keys()) < 0.1
        had = now
    assert len(had) == 1


@pytest.mark.parametrize("shift", [0.0, 0.013, 0.05, 0.087])
def test_every_segment_along_a_strand_has_one_contact(shift):
    one = np.linspace(0.0, 1.0, 11)[:, None] * [0.0, 0.0, 1.0]
    points, offsets = lines(one, one + np.array([0.001, 0.0, shift]))
    near = near_pairs(points, offsets, 0.002)
    assert len(near.distances) >= 18
    found, shares = approaches(near, every(near), points)
    np.testing.assert_allclose(np.bincount(found.segments[:, 0], shares)[:10], 1.0)


def test_contacts_of_two_strands_do_not_jump_as_they_turn_on_each_other():
    """From along each other to across: overlaps of segments, over that of the lines, end as one contact."""
    one, overlaps = np.linspace(-1.0, 1.0, 21)[:, None] * [0.0, 0.0, 1.0], []
    for angle in np.radians(np.linspace(20.0, 90.0, 2801)):
        turned = one[:, 2:] * [np.sin(angle), 0.0, np.cos(angle)]
        points, offsets = lines(one, turned + np.array([0.013, 0.1, 0.007]))
        near = near_pairs(points, offsets, 0.2)
        found, shares = approaches(near, np.diff(near.segments // 21)[:, 0] > 0, points)
        depths = shares * np.maximum(0.11 - found.distances, 0.0) / 0.01
        overlaps.append(np.bincount(found.segments[:, 0], depths, 20))
    assert np.abs(np.diff(overlaps, axis=0)).max() < 0.1
    assert overlaps[0].sum() > 2.0 and overlaps[-1].sum() == pytest.approx(1.0, abs=0.1)


def test_every_turn_of_a_coil_is_approached():
    turns = np.linspace(0.0, 3.0, 61)[:, None]
    coil = np.concatenate([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns), 0.01 * turns], axis=1)
    near = near_pairs(coil, np.array([0, 61], np.int32), 0.025)
    found, _ = approaches(near, every(near), coil)
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
    (found, shares), (wanted, right) = (
        approaches(everything, marked, points),
        approaches(expected, every(expected), points),
    )
    np.testing.assert_array_equal(found.segments, wanted.segments)
    np.testing.assert_array_equal(shares, right)


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
