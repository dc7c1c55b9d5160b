"""Depths are those of points in a ball."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.levelset.bake import bake
from hairpipe.nodes.measure_contact import measure_contact
from hairpipe.values import Strands


def test_depths_are_counted_without_the_roots(sphere):
    ball, other = (bake(sphere(0.05, (x, 0.0, 0.0)), 0.0025, 8.0) for x in (0.0, 0.2))
    away = np.full((200, 3), 1.0, np.float32)
    away[0] = away[100] = 0.0
    one = away.copy()
    one[1], one[2], one[150] = (0.048, 0.0, 0.0), (0.0, 0.045, 0.0), (0.0, 0.0, 0.049)
    both = one.copy()
    both[151:154] = [[0.2, 0.041, 0.0], [0.155, 0.0, 0.0], [0.2, 0.0, 0.051]]
    offsets = np.array([0, 100, 200], np.int32)
    values = {n: Strands(p, p * 0, offsets, 8e-5) for n, p in ((3, away), (4, one), (6, both))}
    frames = tuple(values)
    hair, (first, second) = (
        Frames(frames, values.__getitem__),
        (Frames(frames, dict.fromkeys(frames, s).__getitem__) for s in (ball, other)),
    )
    table = measure_contact(hair, (first, second), None, Time(3, 10.0))
    assert table["time [s]"] == pytest.approx([0.0, 0.1, 0.3])
    assert table["points inside"].tolist() == [0, 3, 5] and table["points"].tolist() == [198] * 3
    assert table["deepest [mm]"] == pytest.approx([0.0, 5.0, 9.0], abs=0.1)
    assert table["99 % quantile [mm]"] == pytest.approx([0.0, 1.03, 5.0], abs=0.15)
    alone = measure_contact(hair, (first,), None, Time(3, 10.0))
    assert alone["points inside"].tolist() == [0, 3, 3]


def test_depth_below_the_band_is_exact_and_not_pinched(sphere):
    ball = bake(sphere(0.05), 0.0025, 8.0)
    before = np.full((3, 3), 1.0, np.float32)
    after = before.copy()
    after[1] = [0.012, 0.0, 0.0]
    values = {n: Strands(p, p * 0, np.array([0, 3], np.int32), 8e-5) for n, p in enumerate((before, after))}
    table = measure_contact(
        Frames((0, 1), values.__getitem__), (Frames((0, 1), {0: ball, 1: ball}.__getitem__),), None, Time(0, 24.0)
    )
    assert table["points inside"].tolist() == [0, 1] and table["points pinched"].tolist() == [0, 0]
    assert table["deepest [mm]"][1] == pytest.approx(38.0, abs=1.0)


def test_strands_that_began_inside_count_once_outside(sphere):
    """Two free points in a ball: one comes out, then the other, then one goes in again."""
    ball = bake(sphere(0.05), 0.0025, 8.0)
    values = {}
    for frame, (first, second) in enumerate([(0.045, 0.04), (0.06, 0.04), (0.06, 0.07), (0.047, 0.07)]):
        points = np.array([[1.0, 0, 0], [first, 0, 0], [second, 0, 0]], np.float32)
        values[frame] = Strands(points, 0 * points, np.array([0, 3], np.int32), 8e-5)
    frames = tuple(values)
    surface = Frames(frames, dict.fromkeys(frames, ball).__getitem__)
    table = measure_contact(Frames(frames, values.__getitem__), (surface,), None, Time(0, 24.0))
    assert table["points still inside"].tolist() == [2, 1, 0, 0] and table["points inside"].tolist() == [0, 0, 0, 1]
    assert table["still inside [mm]"] == pytest.approx([10.0, 10.0, 0.0, 0.0], abs=0.1)
    assert table["deepest [mm]"] == pytest.approx([0.0, 0.0, 0.0, 3.0], abs=0.1)


def test_pinched_points_are_counted_separately(sphere):
    """In the lens where two balls overlap by 20 mm there is no room; on the far side of one there is."""
    left, right = (bake(sphere(0.05, (x, 0.0, 0.0)), 0.0025, 8.0) for x in (-0.04, 0.04))
    before = np.full((4, 3), 1.0, np.float32)
    after = before.copy()
    after[1:3] = [[0.001, 0.0, 0.0], [-0.087, 0.0, 0.0]]
    values = {n: Strands(p, p * 0, np.array([0, 4], np.int32), 8e-5) for n, p in enumerate((before, after))}
    surfaces = tuple(Frames((0, 1), {0: s, 1: s}.__getitem__) for s in (left, right))
    table = measure_contact(Frames((0, 1), values.__getitem__), surfaces, None, Time(0, 24.0))
    assert table["points inside"].tolist() == [0, 1] and table["points pinched"].tolist() == [0, 1]
    assert table["deepest [mm]"] == pytest.approx([0.0, 3.0], abs=0.1)
    assert table["pinched [mm]"] == pytest.approx([0.0, 11.0], abs=0.3)
