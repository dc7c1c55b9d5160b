"""Which frames stand for a shot, and the hardest motion of it."""

import numpy as np
import pytest

from hairpipe.app.tune.sampling import PATCHES, SLACK, STILL, STRANDS, RootMotion, Sample, hardest, other_sample
from hairpipe.app.tune.sampling import choose_sample as choose

FRAMES = range(1001, 1101)


def choose_sample(frames: range, fps: float, motion: np.ndarray | None, total: int) -> Sample:
    return choose(frames, fps, motion, total, STRANDS, PATCHES)


def jolt(at: int, strength: float = 1.0) -> np.ndarray:
    motion = np.zeros(len(FRAMES))
    motion[at - 1001 : at - 1001 + 4] = strength
    return motion


@pytest.mark.parametrize("at", [1001, 1005, 1040, 1097])
def test_the_frames_that_move_most_are_measured(at):
    sample = choose_sample(FRAMES, 24.0, jolt(at) + 0.1, 5000)
    seen = [frame for frame in range(at, at + 4) if frame > 1001]
    assert set(seen) <= set(sample.frames) and len(sample.frames) == 12
    assert sample.begin == max(1001, sample.first - 12) and sample.last <= 1100


def test_where_nothing_moves_hair_has_time_to_settle_in():
    for motion in (None, np.zeros(len(FRAMES)), np.ones(len(FRAMES))):
        sample = choose_sample(FRAMES, 24.0, motion, 5000)
        assert (sample.begin, sample.first, sample.last) == (1001, 1013, 1024)


def test_strands_come_in_equal_patches_and_no_more_than_there_are():
    assert choose(FRAMES, 24.0, None, 5000, 90, 4).strands == 92
    few = choose_sample(FRAMES, 24.0, None, 3)
    assert (few.strands, few.patches) == (3, 3)


def test_another_sample_has_other_frames_and_other_strands():
    motion = jolt(1040, 2.0) + jolt(1080)
    sample = choose_sample(FRAMES, 24.0, motion, 5000)
    other = other_sample([sample], FRAMES, 24.0, motion, 5000)
    assert not set(sample.frames) & set(other.frames) and set(range(1080, 1084)) <= set(other.frames)
    assert other.number == 1 and other.strands == sample.strands


def test_another_sample_of_few_strands_overlaps():
    frames = range(1, 21)
    sample = choose_sample(frames, 24.0, None, 20)
    other = other_sample([sample], frames, 24.0, None, 20)
    assert other.number == 0 and len(set(other.frames) & set(sample.frames)) < len(sample.frames)


def test_a_third_sample_has_strands_or_frames_of_neither():
    motion = jolt(1020, 3.0) + jolt(1050, 2.0) + jolt(1080)
    first = choose_sample(FRAMES, 24.0, motion, 5000)
    second = other_sample([first], FRAMES, 24.0, motion, 5000)
    third = other_sample([first, second], FRAMES, 24.0, motion, 5000)
    assert third.number == 2 and set(range(1080, 1084)) <= set(third.frames)
    few = other_sample([first, second], FRAMES, 24.0, motion, 200)  # strands of the second, at frames of the first
    assert few.number == 1 and set(range(1020, 1024)) <= set(few.frames)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_shortest_shots_have_a_sample(count):
    sample = choose_sample(range(1, count + 1), 24.0, None, 20)
    assert 1 <= sample.begin <= sample.first <= sample.last <= count


def test_the_hardest_half_second_counts():
    """A swing at w over 2 s whose amplitude doubles half way: rms of the acceleration is a w^2 / sqrt(2)."""
    fps, w, a = 240.0, 4.0 * np.pi, 0.1
    times = np.arange(0.0, 2.0, 1.0 / fps)
    amplitude = np.where(times < 1.0, a, 2.0 * a)
    found = hardest(np.abs(amplitude * w * np.cos(w * times)), amplitude * w**2 * np.sin(w * times), fps)
    assert found.speed == pytest.approx(2.0 * a * w, rel=1e-3)
    assert found.acceleration == pytest.approx(2.0 * a * w**2 / np.sqrt(2.0), rel=1e-2)


@pytest.mark.parametrize("count", [1, 2, 3, 100])
def test_constant_acceleration_is_its_own_mean(count):
    found = hardest(np.linspace(0.0, 1.0, count), np.full(count, 3.0), 24.0)
    assert found.acceleration == pytest.approx(3.0)


def test_a_motion_includes_easier_ones():
    motion = RootMotion(0.5, 3.0)
    assert motion.includes(motion) and motion.includes(STILL) and not STILL.includes(motion)
    for harder in (RootMotion(0.5 * SLACK + 1e-3, 3.0), RootMotion(0.5, 3.0 * SLACK + 1e-3)):
        assert not motion.includes(harder) and harder.includes(motion)
