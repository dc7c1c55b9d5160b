"""The path of a part's pose between two frames."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.levelset.collider_parts import part_poses_at, path_between

FRAME = 1 / 24


def pose(t):
    """A motion without any symmetry, [R | p] at times in frames, (3, 4)."""
    turn = Rotation.from_rotvec([0.3 * np.sin(t), 0.8 * t, 0.2 * t * t]) * Rotation.from_rotvec([0.5 * t, 0.0, 0.4])
    return np.column_stack([turn.as_matrix(), [np.sin(t), t * t, 0.3 - t]])


def rate(t, e=1e-5):
    return (pose(t + e) - pose(t - e)) / (2 * e * FRAME)


def path(t):
    """The path from frame t to t + 1."""
    return path_between(*(np.array([f(s)]) for s in (t, t + 1) for f in (pose, rate)), FRAME)


def stance(t, a):
    return part_poses_at(path(t), np.array([a * FRAME]))


@pytest.mark.parametrize("a", [0.0, 1.0])
def test_it_goes_through_the_frames_as_they_are(a):
    now = stance(0.0, a)
    assert np.allclose(now.turns[0, 0], pose(a)[:, :3], atol=1e-14)
    assert np.allclose(now.places[0, 0], pose(a)[:, 3], atol=1e-14)
    assert np.allclose(now.drifts[0, 0], rate(a)[:, 3], atol=1e-12)
    W = rate(a)[:, :3] @ pose(a)[:, :3].T
    assert np.allclose(now.spins[0, 0], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-7)


def test_velocities_are_those_of_the_path_and_do_not_jump_at_a_frame():
    e = 1e-6
    for t, a in ((0.0, 0.2), (0.0, 0.5), (0.0, 0.9), (1.0, 0.4)):
        before, now, after = stance(t, a - e), stance(t, a), stance(t, a + e)
        slope = (after.turns - before.turns)[0, 0] / (2 * e * FRAME)
        W = slope @ now.turns[0, 0].T
        assert np.allclose(now.spins[0, 0], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-6)
        assert np.allclose(now.drifts, (after.places - before.places) / (2 * e * FRAME), atol=1e-6)
    end, begin = stance(0.0, 1.0), stance(1.0, 0.0)
    for one, other in zip(end[1:], begin[1:], strict=True):  # but the time since the first frame
        assert np.allclose(one, other, atol=1e-7)


def test_its_error_falls_with_the_fourth_power_of_the_interval():
    def worst(step):
        found = path_between(*(np.array([f(s)]) for s in (0.3, 0.3 + step) for f in (pose, rate)), FRAME * step)
        middle = part_poses_at(found, np.array([0.5 * FRAME * step]))
        true = pose(0.3 + 0.5 * step)
        return np.abs(middle.turns[0, 0] - true[:, :3]).max(), np.abs(middle.places[0, 0] - true[:, 3]).max()

    for coarse, fine in zip(worst(0.4), worst(0.2), strict=True):
        assert 12.0 < coarse / fine < 20.0


def test_a_steady_turn_and_a_parabola_are_exact():
    w = np.array([0.2, 0.9, -0.4])

    def at(a):
        return np.column_stack([Rotation.from_rotvec(w * a).as_matrix(), [a, a * a, 0.0]])

    rates = [(at(a + 1e-5) - at(a - 1e-5)) / (2e-5 * FRAME) for a in (0.0, 1.0)]
    found = path_between(at(0.0)[None], rates[0][None], at(1.0)[None], rates[1][None], FRAME)
    times = np.linspace(0.0, 1.0, 7)
    now = part_poses_at(found, times * FRAME)
    assert np.allclose(now.turns[:, 0], [at(a)[:, :3] for a in times], atol=1e-9)
    assert np.allclose(now.places[:, 0], [at(a)[:, 3] for a in times], atol=1e-9)
