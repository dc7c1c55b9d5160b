"""Equal segments along curves, and how many."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from hairpipe.errors import BadInput
from hairpipe.groom.resampling import (
    Cut,
    arc_length,
    catmull_rom,
    divide,
    equal_segments,
    fitting,
    smooth,
    spline_knots,
    stride,
    stride_on,
)
from hairpipe.groom.settings import SHORTEST
from hairpipe.strands.calibration import softenings
from hairpipe.strands.material import Material


def chords(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def arc(angle, count=2001, radius=2.0):
    t = np.linspace(0, angle, count)
    return radius * np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)


def off_polyline(points, curve):
    a, ab = curve[:-1], np.diff(curve, axis=0)
    t = np.clip(np.einsum("pks,ks->pk", points[:, None] - a, ab) / np.sum(ab**2, axis=1), 0, 1)
    return np.linalg.norm(points[:, None] - (a + t[..., None] * ab), axis=2).min(axis=1)


def crooked(seed, count=30):
    steps = np.random.default_rng(seed).normal(size=(count, 3)) * 0.4 + (0.0, -1.0, 0.0)
    return np.cumsum(steps, axis=0)


@pytest.mark.parametrize("segments", [1, 2, 7, 40])
def test_an_arc_is_divided_into_the_chords_of_a_regular_polygon(segments):
    points = np.empty((segments + 1, 3))
    divide(arc(2.5), points)
    assert np.allclose(chords(points), 2 * 2.0 * np.sin(2.5 / segments / 2), rtol=1e-5)
    assert np.allclose(points[[0, -1]], arc(2.5)[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_any_curve_is_divided_into_equal_chords_on_it_from_end_to_end(seed):
    curve, points = crooked(seed), np.empty((13, 3))
    divide(curve, points)
    assert np.ptp(chords(points)) < 1e-9
    assert np.allclose(points[[0, -1]], curve[[0, -1]], atol=1e-8)
    assert off_polyline(points, curve).max() < 1e-9


def test_a_straight_line_is_divided_exactly():
    points = np.empty((6, 3))
    divide(np.array([[0.0, 0, 0], [0.1, 0, 0], [0.15, 0, 0], [1, 0, 0]]), points)
    assert np.allclose(points[:, 0], np.linspace(0, 1, 6), atol=1e-8)


def test_dividers_stop_at_the_end_or_go_straight_on():
    curve, points = np.array([[0.0, 0, 0], [0, -1, 0], [1, -1, 0]]), np.full((5, 3), np.nan)
    assert stride(curve, 0.9, points) == 3
    assert np.allclose(chords(points[:3]), 0.9) and np.isnan(points[3:]).all()
    stride_on(curve, 0.9, points)
    assert np.allclose(chords(points), 0.9)
    assert np.allclose(points[4] - points[3], (0.9, 0, 0))
    assert stride(curve, 0.3, points) == 5


def test_smooth_curves_go_through_their_points_and_keep_parabolas():
    t = np.linspace(-1, 1, 9)
    points = np.stack([t, t**2, 0 * t], axis=1)
    curve = smooth(points)
    assert np.allclose(curve[::8], points)
    inner = curve[8:-8]
    assert np.allclose(inner[:, 1], inner[:, 0] ** 2, atol=1e-12)
    half = catmull_rom((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 1.0, 0.0), (3.0, 0.0, 0.0), 0.5)
    assert np.allclose(half, (1.5, 0.5 * 9 / 8, 0))


def test_strands_are_cut_apart_from_each_other():
    strands = [crooked(1), arc(1.0, 5), np.array([[0.0, 0, 0], [0, 0, 2.0]])]
    offsets = np.cumsum([0] + [len(s) for s in strands]).astype(np.int32)
    new = np.array([0, 9, 14, 17], np.int32)
    points = equal_segments(np.concatenate(strands), offsets, new)
    for strand, first, last in zip(strands, new[:-1], new[1:], strict=True):
        assert np.ptp(chords(points[first:last])) < 1e-8
        assert np.allclose(points[[first, last - 1]], strand[[0, -1]], atol=1e-7)


def test_the_arc_length_of_a_polygon_is_that_of_its_sides():
    assert np.isclose(arc_length(arc(2.5)), 5.0, rtol=1e-6)


def test_knots_of_a_b_spline_are_those_of_scipy_and_its_ends_are_reached():
    strands = [crooked(seed, count) for seed, count in enumerate((5, 2, 9))]
    offsets = np.array([0, 5, 7, 16])
    found = np.split(spline_knots(np.concatenate(strands), offsets), offsets[1:-1])
    for hull, knots in zip(strands, found, strict=True):
        mirrored = np.concatenate([[2 * hull[0] - hull[1]], hull, [2 * hull[-1] - hull[-2]]])
        spline = BSpline(np.arange(len(mirrored) + 4) - 3.0, mirrored, 3)
        np.testing.assert_allclose(knots, spline(np.arange(len(hull))), atol=1e-12)
        np.testing.assert_allclose(knots[[0, -1]], hull[[0, -1]])


def test_messages_are_not_repeated():
    with pytest.raises(BadInput, match=r"segments = 9 and segment_length = 0.01 are both given \(one of the two\)"):
        Cut(9, 0.01)


def test_segments_by_number_length_or_default():
    lengths = np.array([0.0095, 0.01, 0.0501])
    assert Cut(7).wanted(lengths, 50).tolist() == [7, 7, 7]
    assert Cut(segment_length=0.01).wanted(lengths, 50).tolist() == [1, 1, 6]
    assert Cut().wanted(lengths, 50).tolist() == [50, 50, 50]
    assert int(Cut(segment_length=0.01).wanted(0.3, 50)) == 30


def test_curls_have_sixteen_segments_per_turn_and_straight_hair_one_per_5_mm():
    lengths, turns = np.array([0.3, 0.3, 0.3, 0.02, 9.0]), np.array([np.inf, 0.099, 0.03, 0.001, np.inf])
    counts = fitting(lengths, turns)
    assert counts.tolist() == [60, 60, 160, 200, 200]
    assert (counts * turns / lengths >= 15.99)[:3].all()


def test_the_shortest_segment_is_a_rod_of_common_hair():
    given = Material().softening
    found = softenings(Material(), np.array([SHORTEST, 0.6 * SHORTEST]))
    assert found[0] == given > found[1]
