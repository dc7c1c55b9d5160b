"""No two segments that meet in a step are missed, and not too many others are listed."""

import numpy as np
import pytest

from hairpipe.contact.collision import crossings, neighbourhood, swept_pairs, swept_pairs_of
from hairpipe.geometry.segments import key_of

from ...segment_scenes import distances_of, every_pair

MOTIONS = {"a little": 0.0, "a turn": 0.02, "one strand is thrown": 0.0, "all ways": 0.0, "rest": 0.02, "together": 0.0}
"""And reach [m]."""


def swept(before, after, offsets, reach, ignored=None):
    return swept_pairs(neighbourhood(before, after, offsets, reach), ignored)


def moved(points, motion):
    rng = np.random.default_rng(8)
    noise = rng.normal(size=points.shape) * np.ptp(points[:-9], axis=0).max()
    if motion == "a little":
        return points + 0.01 * noise
    if motion == "a turn":
        return points + 0.2 * np.cross([0.1, 1.0, 0.2], points) + [1.0, 2.0, 3.0] + 0.001 * noise
    if motion == "one strand is thrown":
        after = points + 0.003 * noise
        after[54:63] += [500.0, 20.0, 0.0]
        return after
    return {"all ways": points + 0.5 * noise, "rest": points, "together": points + 1.0}[motion]


@pytest.mark.parametrize("motion", MOTIONS)
def test_none_that_meet_are_missed(scene, motion):
    (before, offsets, _), reach = scene, MOTIONS[motion]
    after = moved(before, motion)
    found = np.sort(key_of(swept(before, after, offsets, reach)))
    assert (np.diff(found) > 0).all()
    i, j = every_pair(offsets)
    listed = np.isin(key_of(np.stack([i, j], axis=1)), found)
    for time in np.linspace(0, 1, 6):
        now = (1 - time) * before + time * after
        assert listed[distances_of(now, i, j) <= reach - 1e-9 * np.abs(now).max()].all()
    crossed = crossings(before, after, np.stack([i, j], axis=1)[~listed].astype(np.int32))
    sizes = np.abs(before).max()
    assert len(crossed.times) == 0 or sizes > 1e5


def test_ignored_pairs_are_excluded(scene):
    before, offsets, reach = scene
    after = moved(before, "a little")
    everything = np.sort(key_of(swept(before, after, offsets, reach)))
    some = np.sort(key_of(swept(before, after, offsets, reach, everything[::2])))
    np.testing.assert_array_equal(some, everything[1::2])


def test_threads_do_not_matter(hair, same_on_threads):
    before, after, offsets = hair
    assert len(same_on_threads(lambda: swept(before, after, offsets, 1e-3))) > 100


def test_few_are_listed_that_do_not_come_near(few_hairs):
    """In a shake only those within half their relative motion, also when a strand is flung far."""
    before, after, offsets = (np.ascontiguousarray(part) for part in few_hairs)
    before, after = 0.1 * before, before * 0.1 + (after - before)
    middle, half = 0.5 * (before + after), 0.5 * (after - before)
    i, j = every_pair(offsets)
    gains = [np.linalg.norm(half[i + a] - half[j + b], axis=1) for a in (0, 1) for b in (0, 1)]
    bound = distances_of(middle, i, j) <= np.max(gains, axis=0)
    found = swept(before, after, offsets, 0.0)
    assert len(found) <= 1.01 * bound.sum()
    after[:11] += [300.0, 0.0, 0.0]
    flung = swept(before, after, offsets, 0.0)
    assert (flung[:, 0] >= 11).sum() <= 1.02 * len(found)


def test_hair_that_slides_along_hair_is_listed_less_where_it_stays_out_of_reach():
    """Two layers, askew to all axes, of which one slides along the other by more than their distance."""
    grid = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0), [0.0, 0.5], indexing="ij"), axis=-1)
    points = grid.transpose(2, 0, 1, 3).reshape(-1, 3) @ np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    offsets = np.arange(0, len(points) + 1, 12, dtype=np.int32)
    above, along = np.arange(len(points)) >= len(points) // 2, points[1] - points[0]
    after = points + above[:, None] * 0.9 * along
    assert len(swept(points, after, offsets, 0.45)) < 0.5 * len(swept(points, after, offsets, 0.55))


@pytest.mark.parametrize("motion", ["a little", "a turn", "one strand is thrown", "rest"])
def test_changed_motion_is_found(scene, motion):
    before, offsets, reach = scene
    after = moved(before, motion)
    around = neighbourhood(before, after, offsets, reach)
    i, j = every_pair(offsets)
    struck = np.zeros(len(before), bool)
    struck[::7] = True
    ends = after + struck[:, None] * np.array([0.05, -0.02, 0.01]) * np.ptp(before[:-9], axis=0).max()
    segments = np.unique([i, j])
    touched = segments[struck[segments] | struck[segments + 1]].astype(np.int32)
    found = np.sort(key_of(swept_pairs_of(around, touched, before, ends)))
    assert (np.diff(found) > 0).all()
    concerned = np.isin(i, touched) | np.isin(j, touched)
    listed = np.isin(key_of(np.stack([i, j], axis=1)), found)
    for time in np.linspace(0, 1, 6):
        now = (1 - time) * before + time * ends
        near = distances_of(now, i, j) <= reach - 1e-9 * np.abs(now).max()
        assert listed[near & concerned].all()
