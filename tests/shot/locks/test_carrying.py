"""Hairs that follow go where rigid motion takes them, keep their lengths, and know when their guides disagree."""

import numpy as np
import pytest

from hairpipe.groom.keys import turns_since
from hairpipe.shot.lock_followers import find_places, interpolated, nearest_guides, renewed
from hairpipe.shot.lock_guides import GuideMotion
from hairpipe.values import Strands
from hairpipe.values.hair import FOLLOWED, no_places
from hairpipe.values.strand_arrays import points_of_strands

STRANDS, SEGMENTS = 12, 9
OFFSETS = np.arange(0, STRANDS * (SEGMENTS + 1) + 1, SEGMENTS + 1, dtype=np.int32)
GUIDES, FOLLOWERS = np.arange(0, STRANDS, 2), np.arange(1, STRANDS, 2)
STILL = np.tile(np.eye(3, 4), (STRANDS, 1, 1)), np.zeros((STRANDS, 3, 4))


@pytest.fixture
def rest():
    """Bent strands side by side, of equal segments."""
    rng = np.random.default_rng(3)
    steps = rng.normal([0.0, -1.0, 0.0], 0.3, (STRANDS, SEGMENTS, 3))
    steps *= 7e-3 / np.linalg.norm(steps, axis=2, keepdims=True)
    roots = np.stack([1e-3 * np.arange(STRANDS), np.zeros(STRANDS), 1e-3 * rng.normal(size=STRANDS)], 1)
    return (roots[:, None] + np.concatenate([np.zeros((STRANDS, 1, 3)), np.cumsum(steps, 1)], 1)).reshape(-1, 3)


def motion(rest, points, velocities, roots):
    turns = turns_since(rest, Strands(points, velocities, OFFSETS, 1e-4), *roots)
    return GuideMotion(points, velocities, turns.turns, turns.spins)


def rigid(w, t):
    """Rotation by the angular velocity w after a second, from the series of its matrix; and the shift t."""
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    R, term = np.eye(3), np.eye(3)
    for k in range(1, 40):
        term = term @ W / k
        R = R + term
    return W, R, np.asarray(t)


def follow(rest, now, roots):
    turns, mine = motion(rest, rest, np.zeros_like(rest), STILL).turns, points_of_strands(FOLLOWERS, OFFSETS)
    places = find_places(rest, OFFSETS, GUIDES, mine, turns)
    return interpolated(FOLLOWERS, places, now, OFFSETS, rest, roots, 80e-6)


def test_hair_that_is_moved_rigidly_stays_rigid_and_so_do_its_velocities(rest):
    W, R, t = rigid([0.7, -1.9, 1.1], [0.3, 2.0, -0.4])
    points = rest @ R.T + t
    velocities = (points - t) @ W.T + [0.1, 0.2, 0.3]
    shift = np.tile(np.concatenate([R, t[:, None]], 1), (STRANDS, 1, 1))
    rate = np.tile(np.concatenate([W @ R, [[0.1], [0.2], [0.3]]], 1), (STRANDS, 1, 1))
    x, v, disagreement = follow(rest, motion(rest, points, velocities, (shift, rate)), (shift, rate))
    rows = points_of_strands(FOLLOWERS, OFFSETS)
    np.testing.assert_allclose(x, points[rows], atol=1e-8)  # offsets are kept in single precision
    np.testing.assert_allclose(v, velocities[rows], atol=1e-7)
    assert disagreement.max() < 1e-8


@pytest.fixture
def bent(rest):
    """Guides that wave, each otherwise: positions at a time."""
    phase = np.repeat(np.linspace(0.0, 3.0, STRANDS), SEGMENTS + 1)
    along = np.tile(np.arange(SEGMENTS + 1) / SEGMENTS, STRANDS)

    def at(time):
        sway = along**2 * np.sin(5.0 * time + phase)
        return rest + 0.01 * sway[:, None] * np.array([1.0, 0.2, 0.5])

    return at


def test_lengths_stay_those_of_the_groom_and_roots_where_they_are_led(rest, bent):
    roots = STILL[0].copy(), STILL[1]
    roots[0][:, :, 3] += 1e-3 * np.random.default_rng(0).normal(size=(STRANDS, 3))
    x, _, _ = follow(rest, motion(rest, bent(0.2), np.zeros_like(rest), STILL), roots)
    x = x.reshape(len(FOLLOWERS), SEGMENTS + 1, 3)
    np.testing.assert_allclose(np.linalg.norm(np.diff(x, axis=1), axis=2), 7e-3, rtol=1e-12)
    first = rest[OFFSETS[FOLLOWERS]] + roots[0][FOLLOWERS, :, 3]
    np.testing.assert_allclose(x[:, 0], first, atol=1e-15)


def test_velocities_are_the_derivative_of_positions(rest, bent):
    h, time = 1e-5, 0.3
    speeds = (bent(time + h) - bent(time - h)) / (2 * h)
    _, v, _ = follow(rest, motion(rest, bent(time), speeds, STILL), STILL)
    before, after = (follow(rest, motion(rest, bent(t), speeds, STILL), STILL)[0] for t in (time - h, time + h))
    assert np.abs(v).max() > 0.02
    np.testing.assert_allclose(v, (after - before) / (2 * h), atol=1e-6)


def test_disagreement_grows_with_the_distance_of_guides(rest):
    apart = rest.copy()
    found = []
    for way in (0.0, 1e-3, 2e-3):
        apart[:, 0] = rest[:, 0] + way * np.repeat(np.arange(STRANDS), SEGMENTS + 1)
        found.append(follow(rest, motion(rest, apart, np.zeros_like(rest), STILL), STILL)[2])
    assert found[0].max() < 1e-8 and found[1].min() > 2e-4
    np.testing.assert_allclose(found[2], 2.0 * found[1], rtol=1e-6)


def test_hair_whose_ways_have_nearly_vanished_is_not_flung():
    """What it follows moves at 1 m/s."""
    straight = np.tile(7e-3 * np.arange(SEGMENTS + 1)[:, None] * [0.0, -1.0, 0.0], (STRANDS, 1))
    rest = straight + np.repeat(1e-3 * np.arange(STRANDS), SEGMENTS + 1)[:, None] * [1.0, 0.0, 0.0]
    speeds = np.random.default_rng(5).normal(size=rest.shape)
    speeds /= np.linalg.norm(speeds, axis=1, keepdims=True)
    turns, spins = np.tile(np.eye(3), (len(rest), 1, 1)), np.zeros_like(rest)
    places = find_places(rest, OFFSETS, GUIDES, points_of_strands(FOLLOWERS, OFFSETS), turns)
    folded = GuideMotion(rest * [1.0, 1e-3, 1.0], speeds, turns, spins)
    x, v, _ = interpolated(FOLLOWERS, places, folded, OFFSETS, rest, STILL, 80e-6)
    assert np.linalg.norm(v, axis=1).max() < 2.0
    lengths = np.linalg.norm(np.diff(x.reshape(-1, SEGMENTS + 1, 3), axis=1), axis=2)
    np.testing.assert_allclose(lengths, 7e-3, rtol=1e-9)


def test_neighbour_guides_have_most_places_and_equal_segments():
    offsets, strands = np.array([0, 4, 8, 12, 15, 19, 23, 27], np.int32), np.array([1, 3])
    places = no_places(7)
    # Of the first, strand 2 has four places, 4 three, 0 two; 3 has other segments.
    places.counts[:] = [4, 4, 3, 2, 2, 2, 2]
    places.points[:4] = [[0, 8, 12, 15], [9, 1, 13, 16], [10, 14, 17, 1], [11, 12, 1, 1]]
    places.points[4:, :2] = [[0, 8], [15, 19], [24, 20]]
    np.testing.assert_array_equal(nearest_guides(strands, places, offsets), [[2, 4, 0, 1], [3] * FOLLOWED])


def test_only_points_of_a_lost_guide_are_reassigned(rest):
    turns, mine = motion(rest, rest, np.zeros_like(rest), STILL).turns, points_of_strands(FOLLOWERS, OFFSETS)
    owners = np.repeat(np.arange(STRANDS), np.diff(OFFSETS))
    before, moved = find_places(rest, OFFSETS, GUIDES, mine, turns), rest + 0.01 * np.random.default_rng(4).random(3)
    lost = (owners[before.points] == 4).any(axis=1)
    assert 0 < lost.sum() < len(lost) and (before.counts == FOLLOWED).all()
    carried_now = np.isin(np.arange(STRANDS), [*FOLLOWERS, 4])
    now = renewed(before, FOLLOWERS, carried_now, carried_now, moved, OFFSETS, turns)
    rows = np.isin(points_of_strands(np.flatnonzero(carried_now), OFFSETS), mine)
    for old, new in zip(before, now, strict=True):
        np.testing.assert_array_equal(new[rows][~lost], old[~lost])
    anew = find_places(moved, OFFSETS, GUIDES[GUIDES != 4], mine[lost], turns)
    for found, new in zip(anew, now, strict=True):
        np.testing.assert_array_equal(new[rows][lost], found)
    assert (owners[now.points[~rows]] != 4).all() and (now.counts[~rows] > 0).all()
