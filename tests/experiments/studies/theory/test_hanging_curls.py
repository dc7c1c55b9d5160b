"""Hanging curls against closed forms, Greenhill's column and the boundary-value solution of Kirchhoff's rod."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.theory.clamps import Clamp, hang_rod
from hairpipe.graphs.experiments.studies.theory.hanging_curls import (
    bend_curl,
    helix_height,
    least_variation,
    leaving_curvature,
    leaving_weight,
    local_helix,
)
from hairpipe.graphs.experiments.studies.theory.kirchhoff import Rod

RATIO = 0.74


def test_straight_rod_without_weight_has_the_stiffness_of_its_first_twist():
    assert least_variation(bend_curl(1e-6, 0.0), RATIO) == pytest.approx(RATIO * np.pi**2 / 4, rel=1e-6)


def test_upright_rod_loses_its_stiffness_at_the_weight_of_greenhill():
    below, above = (least_variation(bend_curl(1e-9, -7.837347 * part), RATIO) for part in (0.999, 1.001))
    assert above < 0.0 < below


def test_tip_of_a_hook_is_that_of_the_rod_in_space():
    tangent_down = np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    rod = Rod(1.0, 1.0, RATIO, np.array([0.0, 3.0, 0.0]), np.array([0.0, 20.0, 0.0]))
    tip = hang_rod(rod, Clamp(np.zeros(3), tangent_down)).points[-1]
    np.testing.assert_allclose(bend_curl(3.0, 20.0).tip, [np.hypot(tip[0], tip[2]), tip[1]], atol=1e-6)


def test_hooks_and_coils_leave_their_plane_at_one_border():
    curvature = leaving_curvature(20.0, RATIO)
    assert 5.0 < curvature < 6.5
    weight = leaving_weight(7.0, RATIO)
    coil = bend_curl(7.0, 1.0)
    signs = [np.sign(least_variation(coil := bend_curl(7.0, w, coil), RATIO)) for w in (0.9 * weight, 1.1 * weight)]
    assert signs == [1.0, -1.0]


def test_local_helix_has_no_torque_and_balances_its_tension():
    cosine, rate = local_helix(np.array([0.3, 2.0, 100.0]), 3.0, RATIO)
    sine = np.sqrt(1.0 - cosine**2)
    bent, twisted = rate * sine - 3.0, RATIO * rate * cosine
    np.testing.assert_allclose((bent * sine + twisted * cosine)[:2], 0.0, atol=1e-9)
    np.testing.assert_allclose(
        (twisted * sine - bent * cosine)[:2] * rate[:2], np.array([0.3, 2.0]) * sine[:2], rtol=1e-6
    )
    assert cosine[2] == 1.0 and rate[2] == 0.0
    assert helix_height(30.0, 1e6, RATIO) == pytest.approx(1.0, abs=1e-2)
