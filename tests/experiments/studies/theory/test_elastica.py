"""The heavy elastica solves its equation, and is what other ways find."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.optimize import minimize

from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica


@pytest.mark.parametrize("clamp", [-45.0, 0.0, 45.0, 85.0])
@pytest.mark.parametrize("gamma", [0.1, 10.0, 1000.0])
def test_moment_balances_the_weight_beyond(gamma, clamp):
    """m(s) = -Gamma int_s^1 (x(t) - x(s)) dt, from the shape alone."""
    rod = bend_elastica(gamma, np.deg2rad(clamp))
    x = rod.points[:, 0]
    first = cumulative_trapezoid(x, rod.arc, initial=0)
    beyond = first[-1] - first - x * (1 - rod.arc)
    np.testing.assert_allclose(rod.moment, -gamma * beyond, atol=1e-4 * np.abs(rod.moment).max())
    assert trapezoid(rod.moment, rod.arc) == pytest.approx(rod.angle[-1] - rod.angle[0], rel=1e-3)


def test_tip_of_a_light_rod_sags_by_an_eighth():
    gamma = 1e-3
    np.testing.assert_allclose(bend_elastica(gamma).tip, [1.0, -gamma / 8], atol=1e-7)


@pytest.mark.parametrize("clamp", [-0.5, 0.0, 0.5])
def test_heavy_rod_hangs_but_for_a_layer_at_the_clamp(clamp):
    """There a'' = Gamma cos a, so a' = -sqrt(2 Gamma (1 + sin a)) and x = sqrt(2 (1 + sin clamp) / Gamma)."""
    gamma = 1e6
    assert bend_elastica(gamma, clamp).tip[0] == pytest.approx(np.sqrt(2 * (1 + np.sin(clamp)) / gamma), rel=2e-3)


@pytest.mark.parametrize(("gamma", "clamp"), [(3.0, 0.0), (30.0, 45.0)])
def test_chain_of_rigid_links_with_the_least_energy_agrees(gamma, clamp):
    """E = sum EI (a_i+1 - a_i)^2 / 2 l + weight; the clamp is half a link away; extrapolated from two resolutions."""
    start = np.deg2rad(clamp)

    def tip(links: int) -> np.ndarray:
        length = 1 / links
        carried = gamma * length**2 * (links - np.arange(links) - 0.5)

        def energy(angle: np.ndarray) -> tuple[float, np.ndarray]:
            turns = np.diff(angle, prepend=start)
            stiffness = np.full(links, 1 / length)
            stiffness[0] *= 2
            moment = stiffness * turns
            value = (moment @ turns) / 2 + carried @ np.sin(angle)
            return value, moment - np.append(moment[1:], 0) + carried * np.cos(angle)

        angle = minimize(energy, np.full(links, start), jac=True, method="BFGS", options={"gtol": 1e-7}).x
        return length * np.array([np.cos(angle).sum(), np.sin(angle).sum()])

    coarse, fine = tip(20), tip(40)
    np.testing.assert_allclose(fine + (fine - coarse) / 3, bend_elastica(gamma, start).tip, atol=2e-4)


def test_hanging_and_upright_rods_are_straight():
    np.testing.assert_allclose(bend_elastica(1000.0, -np.pi / 2).tip, [0, -1], atol=1e-12)
    np.testing.assert_allclose(bend_elastica(5.0, np.pi / 2).tip, [0, 1], atol=1e-12)


def test_lost_continuation_is_reported():
    with pytest.raises(ArithmeticError, match="no elastica"):
        bend_elastica(100.0, np.deg2rad(89.99))
