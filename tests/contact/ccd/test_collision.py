"""Segments that meet in a step are listed, crossings are found, and hair thrown at hair does not pass through it."""

import numpy as np
import pytest
from numba import njit

from hairpipe.contact import collision as module
from hairpipe.contact.collision import (
    Candidates,
    collide,
    crossings,
    move_as_one,
    neighbourhood,
    swept_pairs,
    swept_pairs_of,
    touched_by,
)
from hairpipe.geometry.segments import key_of
from hairpipe.laws.settings import Collisions, Thickness

from ...segment_scenes import distances_of, every_pair
from ..rod_scenes import cross, segments_of, thrown

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


def test_threads_do_not_matter_to_pairs(hair, same_on_threads):
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


ROUNDS = 8


@pytest.fixture
def listed(monkeypatch):
    """Count how often all pairs are listed, and those of how many segments."""
    counts = {"all": 0, "some": []}

    def all_pairs(*arguments):
        counts["all"] += 1
        return swept_pairs(*arguments)

    def some_pairs(around, segments, *arguments):
        counts["some"].append(len(segments))
        return swept_pairs_of(around, segments, *arguments)

    swept_pairs, swept_pairs_of = module.swept_pairs, module.swept_pairs_of
    monkeypatch.setattr(module, "swept_pairs", all_pairs)
    monkeypatch.setattr(module, "swept_pairs_of", some_pairs)
    return counts


def assert_none_is_missed(candidates, before, ends, every):
    found = key_of(candidates.of(np.ones(len(before), bool)))
    assert len(np.unique(found)) == len(found)
    met = key_of(crossings(before, ends, every).segments)
    assert len(met) and np.isin(met, found).all()


def wander(points, part, far, rng):
    """Move some of the points, about so far."""
    moves = far * rng.normal(size=points.shape)
    return points + moves * (rng.random((len(points), 1)) < part)


@pytest.mark.parametrize(
    ("part", "far", "ways"),
    [(0.01, 0.1, ""), (0.01, 1.0, "some"), (0.05, 10.0, "all some"), (1.0, 0.1, "all some"), (1.0, 3.0, "all")],
)
def test_none_is_missed_while_ends_change(part, far, ways, listed):
    """Of points that leave where they are by about so many reaches, and of those that come back."""
    rng = np.random.default_rng(11)
    reach, offsets = 0.02, np.arange(41, dtype=np.int32) * 8
    before = (0.05 * rng.normal(size=(40, 8, 3)).cumsum(axis=1) + rng.random((40, 1, 3))).reshape(-1, 3)
    after = before + 0.1 * rng.normal(size=before.shape)
    every = np.stack(every_pair(offsets), axis=1).astype(np.int32)
    candidates, ends = Candidates(before, after, offsets, reach, None), after
    for turn in range(ROUNDS):
        ends = after if turn == ROUNDS - 2 else wander(ends, part, far * reach, rng)
        candidates.renew(ends)
        assert_none_is_missed(candidates, before, ends, every)
        marked = rng.random(len(before)) < 0.1
        touched = touched_by(marked, offsets)
        of = candidates.of(marked)
        listed_now = candidates.of(np.ones(len(before), bool))
        expected = listed_now[touched[listed_now].any(axis=1)]
        np.testing.assert_array_equal(of, expected)
    assert (listed["all"] > 1) == ("all" in ways) and bool(listed["some"]) == ("some" in ways)


def test_nothing_is_listed_again_for_small_moves(listed):
    rng = np.random.default_rng(2)
    offsets = np.arange(21, dtype=np.int32) * 8
    before = rng.random((160, 3))
    after = before + 0.2 * rng.normal(size=before.shape)
    candidates = Candidates(before, after, offsets, 0.1, None)
    for _ in range(ROUNDS):
        moves = rng.normal(size=after.shape)
        candidates.renew(after + 0.0499 * moves / np.linalg.norm(moves, axis=1)[:, None])
    assert listed == {"all": 1, "some": []}


def test_points_are_in_the_segments_they_bound():
    marked = np.array([False, True, False, False, True, False, True])
    assert touched_by(marked, np.array([0, 3, 7], np.int32)).tolist() == [True, True, False, True, True, True, False]


def test_an_end_that_continues_by_half_the_reach_is_not_lost():
    """One end leaves, the other goes to and fro within half the reach, and so does what they may meet."""
    offsets = np.arange(33, dtype=np.int32) * 2
    before = np.repeat(100.0 * np.arange(1, 33)[:, None] * [1.0, 0.0, 0.0], 2, axis=0)
    before[1::2] += [0.0, 10.0, 0.0]
    before[0], before[1] = [-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]
    before[2], before[3] = [4.9, -5.0, 3.0], [4.9, 5.0, 3.0]
    after = before.copy()
    after[2:4, 2] = 0.97
    candidates, ends = Candidates(before, after, offsets, 1.0, None), after.copy()
    for here, there in ((-0.49, 0.97), (0.49, 0.48)):
        ends[0], ends[1], ends[2:4, 2] = [-5.6, 0.0, 0.0], [5.0, 0.0, here], there
        candidates.renew(ends)
    assert np.array_equal(crossings(before, ends, np.array([[0, 2]], np.int32)).segments, [[0, 2]])
    assert [0, 2] in candidates.of(np.ones(len(before), bool)).tolist()


HAIR, SPEED, STEP = 3e-3, 10.0, 1 / 30


def directions(rng, *shape):
    v = rng.normal(size=(*shape, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def crossings_of(before, after):
    """Crossings of pairs, (n, 4, 3): points a b c d."""
    count = len(before)
    pairs = (4 * np.arange(count)[:, None] + [0, 2]).astype(np.int32)
    found = crossings(before.reshape(-1, 3), after.reshape(-1, 3), pairs)
    return found, found.segments[:, 0] // 4


def places(before, after, time):
    """Where the lines cross, as fractions of both segments, and how far apart they are there."""
    a, b, c, d = np.moveaxis(before + time[:, None, None] * (after - before), 1, 0)
    u, v, w = b - a, d - c, a - c
    n = np.cross(u, v)
    nn = (n * n).sum(axis=1)
    s, t = -(np.cross(w, v) * n).sum(axis=1) / nn, -(np.cross(w, u) * n).sum(axis=1) / nn
    return s, t, np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)


@njit
def volume(before, after, time):
    """Six times the volume that four points span at a time."""
    p = before + time * (after - before)
    u, v, w = p[1] - p[0], p[3] - p[2], p[2] - p[0]
    x, y, z = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
    return x * w[0] + y * w[1] + z * w[2]


@njit
def sampled_roots(before, after, samples, roots):
    """Write the roots of the volume that many times tell, (n, 3), inf for none: halved again and again."""
    for k in range(len(before)):
        count, last = 0, volume(before[k], after[k], 0.0)
        for i in range(1, samples + 1):
            value = volume(before[k], after[k], i / samples)
            if (value < 0) != (last < 0):
                low, high = (i - 1) / samples, i / samples
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    if (volume(before[k], after[k], middle) < 0) == (last < 0):
                        low = middle
                    else:
                        high = middle
                roots[k, count] = low
                count += 1
            last = value


def by_sampling(before, after):
    """First crossing of each pair, inf if there is none."""
    roots, first = np.full((len(before), 3), np.inf), np.full(len(before), np.inf)
    sampled_roots(before, after, 200, roots)
    which, number = np.nonzero(np.isfinite(roots))
    s, t, _ = places(before[which], after[which], roots[which, number])
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    np.minimum.at(first, which[inside], roots[which, number][inside])
    return first


def test_of_random_motions_all_that_cross_and_no_others():
    rng = np.random.default_rng(1)
    before = HAIR * rng.normal(size=(40_000, 4, 3))
    after = before + SPEED * STEP * directions(rng, 40_000, 4) * rng.random((40_000, 4, 1)) ** 3
    expected = by_sampling(before, after)
    found, which = crossings_of(before, after)
    times = np.full(len(before), np.inf)
    times[which] = found.times
    # Sampling misses two roots between two samples: what it misses must be a crossing by its own measure.
    both = np.isfinite(expected)
    assert both.sum() > 2000
    assert (times[both] <= expected[both] + 1e-9).all()
    earlier = np.flatnonzero(times < expected - 1e-9)
    assert len(earlier) < 0.01 * both.sum()
    s, t, gap = places(before[earlier], after[earlier], times[earlier])
    assert (gap < 1e-8).all() and (np.minimum(s, t) > -1e-6).all() and (np.maximum(s, t) < 1 + 1e-6).all()


def test_none_is_missed_of_those_made_to_cross():
    """A hundred thousand that meet at a chosen time and place, at up to 10 m/s for 1/30 s, some nearly parallel."""
    rng = np.random.default_rng(2)
    count = 100_000
    time, s, t = rng.random((3, count, 1))
    u, v = HAIR * directions(rng, 2, count)
    v[::4] = u[::4] * rng.uniform(-2, 2, (count // 4, 1)) + 10.0 ** rng.uniform(-8, -3, (count // 4, 1)) * v[::4]
    place = rng.random((count, 3))
    meeting = np.stack([place - s * u, place + (1 - s) * u, place - t * v, place + (1 - t) * v], axis=1)
    way = SPEED * STEP * directions(rng, count, 4) * rng.random((count, 4, 1))
    way[::2] = way[::2, :1] + 0.01 * way[::2]
    before, after = meeting - time[:, None] * way, meeting + (1 - time)[:, None] * way
    found, which = crossings_of(before, after)
    assert len(which) == count
    assert (found.times <= time[:, 0] + 1e-6).all()
    ends = before + found.times[:, None, None] * (after - before)
    s, t = found.fractions.T[:, :, None]
    first, second = (1 - s) * ends[:, 0] + s * ends[:, 1], (1 - t) * ends[:, 2] + t * ends[:, 3]
    sizes = np.linalg.norm(ends[:, [1, 3]] - ends[:, [0, 2]], axis=2).sum(axis=1)
    assert (np.linalg.norm(first - second, axis=1) < 1e-4 * sizes + 1e-12).all()
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1, atol=1e-12)


def test_normals_point_to_where_the_first_came_from():
    rng = np.random.default_rng(3)
    count = 2000
    u, v = HAIR * directions(rng, 2, count)
    n = np.cross(u, v)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    side = rng.choice([-1.0, 1.0], (count, 1))
    meeting = np.stack([-0.5 * u, 0.5 * u, -0.5 * v, 0.5 * v], axis=1)
    away = np.zeros_like(meeting)
    away[:, :2] = 0.01 * (side * n)[:, None]
    found, which = crossings_of(meeting + away, meeting - away)
    assert len(which) == count
    np.testing.assert_allclose(found.normals, side * n, atol=1e-9)
    np.testing.assert_allclose(found.times, 0.5, atol=1e-12)
    np.testing.assert_allclose(found.fractions, 0.5, atol=1e-9)


def one(before, after):
    return crossings_of(np.array([before], float), np.array([after], float))[0]


CROSS = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]], float)
UP = np.array([[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 0, 0]], float)


def test_resting_and_receding_pairs_do_not_cross():
    assert len(one(CROSS + UP, CROSS + UP).times) == 0
    assert len(one(CROSS + 1e-3 * UP, CROSS + UP).times) == 0
    assert len(one(CROSS + UP, CROSS + 1e-3 * UP).times) == 0
    assert len(one(CROSS + UP + 5, CROSS + UP - 7).times) == 0


def test_a_pair_that_touches_at_the_start_is_reported_at_once():
    for way in (-1.0, 0.0, 1.0):
        found = one(CROSS, CROSS + way * UP)
        assert found.times == pytest.approx([0.0])
        assert np.abs(found.normals[0]) == pytest.approx([0, 0, 1])
    assert one(CROSS + UP, CROSS).times == pytest.approx([1.0])


def test_touching_and_going_back_on_a_curved_path():
    """The first turns so that the lines meet at half time and part again: a double root."""
    before = CROSS + 0.25 * UP
    before[2:] += [[0, 0, 0.5], [0, 0, -0.5]]
    after = CROSS + 0.25 * UP
    after[2:] -= [[0, 0, 0.5], [0, 0, -0.5]]
    found = one(before - 0.25 * UP, after - 0.25 * UP)
    assert found.times[0] <= 0.5


@pytest.mark.parametrize("shift", [0.0, 0.7, -1.3])
@pytest.mark.parametrize("turn", [0.0, 1e-15, 1e-9, 1e-7])
def test_parallel_ones_pass_through_each_other_sideways(shift, turn):
    u = np.array([0.3, 0.5, 0.7])
    n = np.array([0.5, -0.3, 0.0])
    lies = np.array([-u, u, (shift - 1) * u, (shift + 1) * u])
    lies[2:] += turn * np.cross(u, n) * [[-1], [1]]
    away = np.array([n, n, 0 * n, 0 * n])
    found = one(lies + away, lies - 2 * away)
    assert found.times == pytest.approx([1 / 3], abs=1e-5)
    assert abs(found.normals[0] @ n) / np.linalg.norm(n) > 0.9 or turn > 1e-8
    assert len(one(lies + away, lies + 0.5 * away).times) == 0
    apart = lies + np.array([3 * u, 3 * u, 0 * u, 0 * u])
    assert len(one(apart + away, apart - away).times) == 0


def test_motion_within_a_plane_is_not_a_crossing():
    """An end comes first: what the paper leaves to nobody. Where one lies across the other in the end they touch."""
    up = np.array([0.0, 3.0, 0.0])
    apart, beyond = CROSS + np.array([0 * up, 0 * up, up, up]), CROSS - np.array([0 * up, 0 * up, up, up])
    assert len(one(apart, beyond).times) == 0
    assert len(one(apart, apart - [1.0, 0.5, 0.0]).times) == 0
    assert one(apart, CROSS).times == pytest.approx([1.0])


def test_an_edge_that_passes_through_a_joint_is_caught():
    """By at least one of the two segments that the joint belongs to, however it is rounded."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        joint, u, v, w, way = rng.normal(size=(5, 3))
        missed = 0
        for side in (v, w):
            meeting = np.array([joint - 0.4 * u, joint + 0.6 * u, joint, joint + side])
            away = np.array([way, way, 0 * way, 0 * way])
            missed += len(one(meeting + 0.3 * away, meeting - 0.7 * away).times) == 0
        assert missed < 2


def test_threads_do_not_matter_to_crossings(same_on_threads):
    before, after = np.random.default_rng(7).normal(size=(2, 3000, 4, 3))
    same_on_threads(lambda: crossings_of(before, after)[0])


LAW = Collisions(Thickness(3e-4), friction=0.3, attempts=10)
DT = 1 / 30


def collided(before, velocities, masses=None, law=LAW, offsets=None):
    """Positions and velocities after a step, and the outcome."""
    masses = np.full(len(before), 4e-8) if masses is None else masses
    offsets = np.arange(0, len(before) + 1, 2).astype(np.int32) if offsets is None else offsets
    outcome = collide(before, before + DT * velocities, masses, offsets, DT, law)
    return before + DT * (velocities + outcome.change), velocities + outcome.change, outcome


def spans(x, i, j):
    """Volume that segments span, six times, and whether they overlap seen along their common normal."""
    a, c, r = x[i + 1] - x[i], x[j + 1] - x[j], x[j] - x[i]
    n = np.cross(a, c)
    nn = (n * n).sum(-1)
    s, t = (np.cross(r, c) * n).sum(-1) / nn, (np.cross(r, a) * n).sum(-1) / nn
    return (n * r).sum(-1), (s > 0) & (s < 1) & (t > 0) & (t < 1)


def crossed(before, after, i, j):
    """Whether segments pass through each other on straight ways: roots of their volume, a cubic, where they overlap."""
    at = np.array([0.0, 1.0, 2.0, 3.0]) / 3
    volumes = np.stack([spans((1 - k) * before + k * after, i, j)[0] for k in at], 1)
    cubic = volumes @ np.linalg.inv(np.vander(at, increasing=True)).T
    frobenius = np.zeros((len(i), 3, 3))
    frobenius[:, [1, 2], [0, 1]] = 1.0
    # One over the time: of what moves as one the volume is constant, and has no term of the third order.
    frobenius[:, :, 2] = -cubic[:, :0:-1] / cubic[:, :1]
    found = np.zeros(len(i), bool)
    for root in np.linalg.eigvals(frobenius).T:
        real = (abs(root.imag) < 1e-9) & (root.real > 1)
        k = 1 / np.where(real, root.real, 1.0)[:, None]
        ends = [(1 - k) * before[p] + k * after[p] for p in (i, i + 1, j, j + 1)]
        rows = np.arange(len(i)) * 4
        found |= real & spans(np.stack(ends, 1).reshape(-1, 3), rows, rows + 2)[1]
    return found


def throw(count, seed=0, apart=10.0):
    """Far apart couples of rods of 10 mm thrown through each other at about 10 m/s, with random turns."""
    rng = np.random.default_rng(seed)

    def unit():
        v = rng.normal(size=(count, 3))
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    meeting = apart * np.arange(count)[:, None] * [1.0, 0.0, 0.0]
    when, points, speeds = rng.uniform(0.05, 0.95, count)[:, None] * DT, [], []
    for _ in range(2):
        along, speed, spin = unit(), 10.0 * unit(), rng.normal(size=(count, 3)) * 0.1
        place = rng.uniform(0.1, 0.9, count)[:, None]
        ends = [meeting - 0.01 * place * along, meeting + 0.01 * (1 - place) * along]
        ways = [speed - spin * place, speed + spin * (1 - place)]
        points += [end - when * way for end, way in zip(ends, ways, strict=True)]
        speeds += ways
    return (np.stack(part, 1).reshape(-1, 3) for part in (points, speeds))


def test_two_hairs_at_ten_metres_per_second_do_not_pass():
    before, _ = cross(0.05)
    velocities = np.outer([1, 1, 0, 0], [0.0, -10.0, 0.0])
    after, speeds, outcome = collided(before, velocities)
    assert (outcome.found, outcome.left) == (1, 0) and outcome.change.any(axis=1).all()
    assert after[0, 1] - after[2, 1] == pytest.approx(LAW.thickness.value)
    np.testing.assert_allclose(speeds - velocities, (after - before) / DT - velocities, atol=1e-12)


def test_hair_that_nearly_touches_is_stopped_where_it_is_and_does_not_rebound():
    before, _ = cross(1e-4)
    after, speeds, _ = collided(before, np.outer([1, 1, 0, 0], [0.0, -10.0, 0.0]))
    assert after[0, 1] - after[2, 1] == pytest.approx(1e-4)
    assert speeds[0, 1] - speeds[2, 1] == pytest.approx(0.0, abs=1e-9)


def test_ten_thousand_thrown_pairs_do_not_cross():
    before, velocities = throw(10_000)
    free = before + DT * velocities
    i = np.arange(0, len(before), 4)
    after, _, outcome = collided(before, velocities)
    assert outcome.found == len(i) and crossed(before, free, i, i + 2).all()
    assert outcome.left == 0
    assert not crossed(before, after, i, i + 2).any()


def throw_bent(count, speed, seed=0, joints=6, dt=1 / 240):
    """Couples of strands of 3 mm long segments, bent at random, thrown through each other [m/s], 1 m apart."""
    rng = np.random.default_rng(seed)
    turns = np.cumsum(rng.normal(size=(2 * count, joints, 3)) * np.where(np.arange(joints) > 0, 0.2, 1.0)[:, None], 1)
    ways = 3e-3 * turns / np.linalg.norm(turns, axis=2, keepdims=True)
    points = np.concatenate([np.zeros((2 * count, 1, 3)), np.cumsum(ways, 1)], 1)
    speeds = rng.normal(size=(2 * count, 1, 3)) + 0.1 * rng.normal(size=points.shape)
    speeds *= speed / np.linalg.norm(speeds, axis=2, keepdims=True)
    meeting = points[:, joints // 2, None] - np.repeat(np.arange(count), 2)[:, None, None] * [1.0, 0.0, 0.0]
    points = points - meeting - np.repeat(rng.uniform(0.1, 0.9, count), 2)[:, None, None] * dt * speeds
    return points.reshape(-1, 3), speeds.reshape(-1, 3)


@pytest.mark.parametrize(("thickness", "speed"), [(1e-3, 5.0), (3e-4, 5.0), (3e-4, 20.0)])
def test_bent_strands_do_not_pass_through_each_other(thickness, speed):
    """A joint hands a crossing on to its next segment, and this one to the next: what attempts leave moves as one."""
    count, joints, dt = 400, 6, 1 / 240
    before, velocities = throw_bent(count, speed)
    offsets = np.arange(0, len(before) + 1, joints + 1).astype(np.int32)
    masses = np.full(len(before), 2e-8)
    after = before + dt * velocities
    rules = [Collisions(Thickness(thickness), attempts=attempts) for attempts in (1, 4, Collisions().attempts)]
    outcomes = [collide(before, after, masses, offsets, dt, rule) for rule in rules]
    i, j = (k.ravel() for k in np.meshgrid(np.arange(joints), np.arange(joints)))
    i, j = (np.add.outer(2 * (joints + 1) * np.arange(count), k).ravel() for k in (i, j + joints + 1))
    assert crossed(before, after, i, j).sum() > 300
    for outcome in outcomes:
        assert not crossed(before, after + dt * outcome.change, i, j).any() and outcome.left == 0
        momenta = masses[:, None] * outcome.change
        assert np.linalg.norm(momenta.sum(0)) < 1e-9 * np.abs(momenta).sum()


def test_zones_keep_their_momentum_or_follow_held_points():
    """Two zones of three segments, of which each shares a point with the next, and a point that belongs to none."""
    rng = np.random.default_rng(2)
    motion = rng.normal(size=(9, 3))
    masses = rng.uniform(1.0, 2.0, 9)
    masses[5] = np.inf
    change = np.where(np.arange(9)[:, None] == 5, 0.0, rng.normal(size=(9, 3)))
    free = motion + 0.1 * change
    move_as_one(change, motion, masses, np.array([[0, 1], [1, 2], [4, 5], [5, 6]]), 0.1)
    ended = motion + 0.1 * change
    assert np.allclose(ended[:4], np.average(free[:4], axis=0, weights=masses[:4]))
    assert np.allclose(ended[4:8], motion[5]) and np.array_equal(change[5], np.zeros(3))
    assert np.array_equal(ended[8], free[8])


@pytest.mark.parametrize("attempts", [4, 12])
def test_zones_do_not_grow_in_packed_hair(attempts, monkeypatch):
    """Each zone would run into further hair, until all of the cloud moved as one, as on a dancer (`salsa.toml`)."""
    before, velocities = thrown(300, 0.01, 0.004, 1.0, 9)
    law = Collisions(Thickness(3e-4), attempts=attempts)
    after, _, outcome = collided(before, velocities, law=law)
    monkeypatch.setattr("hairpipe.contact.collision.move_as_one", lambda *_: None)
    unzoned, _, others = collided(before, velocities, law=law)
    assert outcome.left <= others.left and others.left > 0
    moved = (after != unzoned).any(axis=1).mean()
    assert moved < 0.2 and (moved > 0.0 or outcome.left == others.left)


def test_a_cloud_ends_without_crossings_and_no_speed_is_added():
    before, velocities = thrown(300, 0.03, 0.01, 0.3, 7)
    after, speeds, outcome = collided(before, velocities)
    i, j = (segments_of(300)[k] for k in np.triu_indices(300, 1))
    assert outcome.found > 100
    assert crossed(before, after, i, j).sum() == outcome.left == 0
    assert (speeds**2).sum() < (velocities**2).sum()
    assert np.abs(speeds).max() < 2 * np.abs(velocities).max()
    still = ~outcome.change.any(axis=1)
    assert (after[still] == (before + DT * velocities)[still]).all()


def test_momentum_is_kept():
    before, velocities = throw(50, 3)
    masses = np.random.default_rng(0).uniform(1e-8, 9e-8, len(before))
    _, speeds, outcome = collided(before, velocities, masses)
    change = masses[:, None] * (speeds - velocities)
    assert outcome.change.any(axis=1).sum() > 100
    assert np.linalg.norm(change.sum(0)) < 1e-10 * np.abs(change).sum()


@pytest.mark.parametrize("sideways", [0.05, 20.0])
def test_friction_is_within_the_cone_and_does_not_reverse(sideways):
    before, _ = cross(2e-3)
    before[:2, 0] = [-1.0, 1.0]
    velocities = np.outer([1, 1, 0, 0], [sideways, -1.0, 0.0])
    _, speeds, outcome = collided(before, velocities)
    assert outcome.found == 1
    change = (speeds - velocities)[:2].mean(0) - (speeds - velocities)[2:].mean(0)
    assert 0 < -change[0] <= LAW.friction * change[1] * (1 + 1e-6)
    assert -change[0] <= sideways * (1 + 1e-9)


def test_held_points_do_not_move():
    before, velocities = throw(100, 4)
    masses = np.full(len(before), 4e-8)
    masses[::4] = np.inf
    _, speeds, outcome = collided(before, velocities, masses)
    assert (speeds[::4] == velocities[::4]).all() and not outcome.change[::4].any()
    assert outcome.left == 0


def test_hair_that_is_already_tangled_stays_in_bounds():
    """A dense cloud in which hundreds of crossings share points, started again and again."""
    before, velocities = thrown(200, 0.01, 0.01, 1.0, 9)
    fastest = np.abs(velocities).max()
    for _ in range(5):
        before, velocities, _ = collided(before, velocities, law=Collisions(Thickness(3e-4)))
        assert np.isfinite(before).all() and np.abs(velocities).max() < 3 * fastest


def test_threads_do_not_matter(same_on_threads):
    before, velocities = thrown(200, 0.02, 0.01, 0.3, 8)
    _, _, outcome = same_on_threads(lambda: collided(before, velocities))
    assert outcome.found > 50


def test_ignored_pairs_pass():
    before, _ = cross(0.05)
    velocities = np.outer([1, 1, 0, 0], [0.0, -10.0, 0.0])
    offsets, ignored = np.array([0, 2, 4], np.int32), np.array([2], np.int64)
    outcome = collide(before, before + DT * velocities, np.full(4, 4e-8), offsets, DT, LAW, ignored)
    assert outcome.found == 0 and not outcome.change.any()
