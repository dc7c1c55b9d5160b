"""The way of a strand over the body."""

import numpy as np
import pytest

from hairpipe.geometry.solid import solid_of
from hairpipe.groom.growing import RISE, keep_out, lay, lift_off

STEP = 0.002


@pytest.fixture(scope="module")
def solid(sphere):
    return solid_of(sphere(0.1, level=5))


def laid(solid, root, ahead, comb=(0.0, 0.0, 0.0), layer=0.005, bend=0.03, count=200):
    axis = np.empty((count, 3))
    axis[0] = root
    lay(solid, axis, tuple(ahead), comb, layer, bend, STEP)
    return axis


def test_hair_from_the_top_slides_down_over_the_head_in_its_layer(solid):
    for layer in (0.002, 0.015):
        axis = laid(solid, (0.0, 0.1, 0.0), np.array([0.8, 0.6, 0.0]), comb=(0.7, 0.0, 0.0), layer=layer, bend=STEP)
        height = np.linalg.norm(axis, axis=1) - 0.1
        way = np.arange(200) * STEP
        beside = (axis[:, 1] > 0) & (way > 0.05)
        assert beside.any() and (height[1:] > 0).all()
        assert np.allclose(height[beside], layer * (1 - np.exp(-way[beside] / RISE)), atol=0.0005)


def test_hair_free_of_the_body_hangs(solid):
    axis = laid(solid, (0.1, 0.0, 0.0), (1.0, 0.0, 0.0))
    tangent = np.diff(axis, axis=0) / STEP
    assert np.allclose(tangent[-1], (0, -1, 0), atol=1e-3)
    assert np.allclose(np.linalg.norm(tangent, axis=1), 1)


def test_it_turns_over_the_bending_length(solid):
    """Free hair that starts level turns by dt/ds = (down - t) / bend across t: a shape that scales with bend."""
    level = [laid(solid, (0.1, 0.0, 0.0), (1.0, 0.0, 0.0), bend=bend)[-1, 0] - 0.1 for bend in (0.01, 0.02, 0.04)]
    assert np.allclose(np.diff(np.log(level)), np.log(2), atol=0.15)


def test_the_comb_pulls_only_what_lies_on_the_body(solid):
    top = laid(solid, (0.0, 0.1, 0.0), (0.0, 0.6, -0.8), comb=(0.0, 0.0, -2.0), count=40)
    assert np.allclose(top[:, 0], 0, atol=0.005) and top[-1, 2] < -0.05
    free = laid(solid, (0.1, 0.0, 0.0), (1.0, 0.0, 0.0), comb=(0.0, 0.0, -1.0))
    assert np.allclose(np.diff(free, axis=0)[-1] / STEP, (0, -1, 0), atol=1e-3)


def test_curves_are_lifted_out_of_the_body_and_no_farther(solid):
    t = np.linspace(0, 1, 101)[:, None]
    curve = (1 - t) * (0.1, 0.0, 0.0) + t * (-0.3, 0.02, 0.0)
    lifted = curve.copy()
    lift_off(solid, lifted, 0.003)
    height = np.linalg.norm(lifted, axis=1) - 0.1
    assert np.array_equal(lifted[0], curve[0])
    way = np.linalg.norm(curve - curve[0], axis=1)
    assert (height > 0.003 * np.minimum(way / RISE, 1) - 2e-4).all()
    clear = np.linalg.norm(curve, axis=1) > 0.1035
    assert clear.any() and np.array_equal(lifted[clear], curve[clear])


@pytest.mark.parametrize("start", [(0.1, 0.0, 0.0), (0.0, 0.3, 0.0)], ids=["from the skin", "from above"])
def test_a_curl_that_runs_through_the_body_is_kept_out_and_keeps_its_lengths(solid, start):
    way = np.linspace(0.0, 0.5, 126)[:, None]
    turn = way / 0.03 * 2.0 * np.pi
    aside = np.cross(start, (0.0, 0.0, 10.0)) * 0.006 / np.linalg.norm(start) / 10.0
    curl = np.array(start) * (1.0 - way / np.linalg.norm(start))
    curl = curl + aside * (np.cos(turn) - 1.0) + np.array((0.0, 0.0, 0.006)) * np.sin(turn)
    kept = curl.copy()
    keep_out(solid, kept, 0.001)
    height = np.linalg.norm(kept, axis=1) - 0.1
    middles = np.linalg.norm(0.5 * (kept[1:] + kept[:-1]), axis=1) - 0.1
    assert np.array_equal(kept[0], curl[0]) and np.linalg.norm(curl, axis=1).min() < 0.01
    assert height[1:].min() > 0.0 and height[20:].min() > 0.0004 and middles.min() > -1e-4
    lengths, before = (np.linalg.norm(np.diff(points, axis=0), axis=1) for points in (kept, curl))
    assert np.allclose(lengths, before, rtol=1e-12)


def test_points_outside_of_the_body_are_unchanged(solid):
    curve = np.array((0.1, 0.0, 0.0)) + np.linspace(0.0, 0.2, 41)[:, None] * (0.8, -0.6, 0.0)
    kept = curve.copy()
    keep_out(solid, kept, 0.001)
    assert np.array_equal(kept, curve)
