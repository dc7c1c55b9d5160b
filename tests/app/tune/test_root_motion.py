"""The hardest motion of a shot."""

import numpy as np
import pytest

from hairpipe.app.tune.sampling import SLACK, STILL, RootMotion, hardest


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
