"""The torque that buckles a straight rod."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from hairpipe.graphs.experiments.studies.theory.twist_buckling import buckling_torque, buckling_twist


def test_without_tension_it_is_the_tabled_one():
    """tan(M / 2) = M / 2, as for the column clamped at both ends (Greenhill 1883)."""
    half = brentq(lambda x: np.sin(x) - x * np.cos(x), np.pi, 1.5 * np.pi)
    assert buckling_torque() == pytest.approx(2 * half, rel=1e-10)


@pytest.mark.parametrize("tension", [-30.0, -5.0, 40.0, 400.0])
def test_a_neighbouring_shape_exists_just_there(tension):
    """The exact solution, carried from end to end: w'''' = i M w''' + P w'' with w = w' = 0 at both ends."""

    def gap(torque: float) -> float:
        step = np.diag(np.ones(3), 1).astype(complex)
        step[3, 2:] = tension, 1j * torque
        return np.linalg.svd(expm(step)[:2, 2:], compute_uv=False)[-1]

    found = buckling_torque(tension)
    assert gap(found) < 1e-8 * gap(0.9 * found)
    assert min(gap(part * found) for part in np.linspace(0.05, 0.95, 19)) > 1e-3 * gap(0.9 * found)


def test_a_taut_rod_buckles_as_an_endless_one():
    assert buckling_torque(1e4) == pytest.approx(2 * np.sqrt(1e4), rel=1e-3)


def test_thrust_alone_buckles_it():
    assert buckling_torque(-4 * np.pi**2 + 1e-3) < 0.1
    with pytest.raises(ValueError, match="thrust"):
        buckling_torque(-4 * np.pi**2)


def test_twist_follows_from_the_torque():
    assert buckling_twist(0.1, 8e-9, 6e-9) == pytest.approx(8.98682 * 8 / 6, rel=1e-5)
