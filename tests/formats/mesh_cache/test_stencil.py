"""Interpolation of samples against polynomials of time, for which it is exact."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import stencil_at, take_at

FRAMES = np.arange(1001, 1011) / 24.0
UNEVEN = np.array([0.0, 0.1, 0.13, 0.2, 0.31, 0.35, 0.5])


def parabola(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 0.3 - 2.0 * t + 7.0 * t * t, -2.0 + 14.0 * t


def cubic(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return t**3 - t, 3.0 * t * t - 1.0


def combined(times, at, values, rates, cuts=(), own=False) -> tuple[float, float]:
    samples, weights = stencil_at(times, at, cuts, own)
    pairs = np.stack([values[samples], rates[samples] if own else np.full(len(samples), 1e6)], axis=1)
    return tuple(np.einsum("kij,kj->i", weights, pairs))


@pytest.mark.parametrize("times", [FRAMES - FRAMES[0], UNEVEN])
def test_a_parabola_is_followed_exactly_with_its_velocity(times):
    values, rates = parabola(times)
    for at in np.linspace(times[0], times[-1], 57):
        np.testing.assert_allclose(combined(times, at, values, rates), parabola(at), atol=1e-9)


def test_a_cubic_is_followed_exactly_with_the_velocities_of_the_file():
    values, rates = cubic(UNEVEN)
    for at in np.linspace(0.0, 0.5, 57):
        np.testing.assert_allclose(combined(UNEVEN, at, values, rates, own=True), cubic(at), atol=1e-9)


def test_the_points_at_a_sample_are_its_points_to_the_bit():
    for frame in range(1001, 1011):
        samples, weights = stencil_at(FRAMES, frame / 24.0 + 1e-9, (), False)
        assert (weights[:, 0] == np.where(samples == frame - 1001, [[1.0], [0.0]], 0.0).T).all()


def test_sub_frame_samples_are_the_ones_that_count():
    times = np.arange(0.0, 1.0, 1.0 / 96.0)
    rates = 2.0 * np.pi * np.cos(2.0 * np.pi * times)
    _, fine = combined(times, 0.25 / 3.0, np.sin(2.0 * np.pi * times), rates)
    _, coarse = combined(times[::4], 0.25 / 3.0, np.sin(2.0 * np.pi * times[::4]), rates)
    truth = 2.0 * np.pi * np.cos(np.pi / 6.0)
    assert abs(fine - truth) < 0.1 * abs(coarse - truth)


def test_the_ends_hold_still_outside_of_the_samples():
    values, rates = parabola(FRAMES - FRAMES[0])
    assert combined(FRAMES, FRAMES[0] - 0.2, values, rates) == (values[0], 0.0)
    assert combined(FRAMES, FRAMES[-1] + 0.2, values, rates, own=True) == (values[-1], 0.0)


@pytest.mark.parametrize("own", [False, True])
def test_velocities_at_a_cut_do_not_see_the_jump(own):
    times = FRAMES - FRAMES[0]
    values = np.where(times < times[5], 3.0 * times, 100.0 + 5.0 * times)
    rates = np.gradient(values, times)  # over the cut, as programs write them
    cuts = [(times[4], times[5])]
    for frame, slope in ((3, 3.0), (4, 3.0), (5, 5.0), (6, 5.0)):
        found = combined(times, times[frame], values, rates, cuts, own)
        np.testing.assert_allclose(found, (values[frame], slope), atol=1e-9)


def test_samples_between_the_frames_at_a_cut_are_not_used():
    times = np.arange(0.0, 2.0, 0.25)  # frames at 0 and 1: samples at 0.25, 0.5, 0.75 may be of either take
    take = take_at(times, 0.0, [(0.0, 1.0)])
    assert (take.first, take.last) == (0, 0)
    assert take_at(times, 1.0, [(0.0, 1.0)]).first == 4


def test_an_instant_before_a_cut_without_a_sample_goes_on_straight():
    times = np.array([0.0, 0.9, 2.0, 3.0])
    values = np.array([0.0, 0.9, 50.0, 51.0])
    np.testing.assert_allclose(combined(times, 1.0, values, values, [(1.0, 2.0)]), (1.0, 1.0))


def test_a_single_sample_holds_still():
    assert combined(np.array([2.0]), 1.0, np.array([7.0]), np.array([1.0])) == (7.0, 0.0)


def test_a_take_without_samples_is_refused():
    with pytest.raises(BadInput, match="no sample between the two cuts"):
        take_at(np.array([0.0, 5.0]), 2.0, [(1.0, 1.5), (3.0, 3.5)])


def test_a_changed_sample_changes_two_frames_before_and_after():
    for frame in range(10):
        samples, weights = stencil_at(FRAMES, FRAMES[frame], (), False)
        used = samples[weights.any(axis=(1, 2))]
        assert used.min() >= frame - 2 and used.max() <= frame + 2
