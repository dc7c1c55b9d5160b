"""A soft hair that hangs in wind, through the whole solver, against the balance of its drag and its weight."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import root_scalar

from hairpipe.laws.settings import Coefficients, Scheme, StepControl, Wind
from hairpipe.strands.material import Material

SOFT = Material(young=1e7, softening=1.0)
WEIGHT = SOFT.line_density * 9.81


def cylinder(speed):
    re = 1.2 * SOFT.diameter * speed / 1.8e-5
    return 0.5 * 1.2 * SOFT.diameter * speed**2 * (1.18 + 6.8 / re**0.89 + 1.96 / re**0.5)


def fallen(scene, straight, scheme, wind, step=1 / 1920):
    """The way of the tip of a hair that is let go of from the horizontal, after an eighth of a second."""
    s = scene([straight(0.1, 10, [1, 0, 0])], SOFT)
    s.scene = replace(s.scene, wind=wind, scheme=scheme, steps=StepControl(step), strain=None)
    before = s.axis[-1]
    return np.linalg.norm(s.run(0.125).axis[-1] - before)


@pytest.mark.parametrize(
    "scheme",
    [
        Scheme("bdf2"),
        Scheme("backward_euler", "printed"),
        Scheme("nine_steps", "printed", "trapezoid"),
        Scheme("nine_steps", "printed", "full_step"),
    ],
)
def test_still_air_brakes_what_falls_in_every_scheme(scene, straight, scheme):
    """Also where a solve begins with hair at rest, by which its drag must not go."""
    still = Wind((0.0, 0.0, 0.0))
    braked, free = fallen(scene, straight, Scheme(), still), fallen(scene, straight, Scheme(), None)
    assert braked < 0.8 * free
    assert fallen(scene, straight, scheme, still) == pytest.approx(braked, rel=0.01)


@pytest.mark.parametrize(
    ("coefficients", "drag"), [(None, cylinder), (Coefficients(2e-4, 5e-5), lambda speed: 2e-4 * speed)]
)
def test_it_leans_until_its_weight_across_is_the_drag(scene, straight, coefficients, drag):
    """Straight but at the root: drag(U cos a) = w sin a on every metre, whatever pulls along it."""
    s = scene([straight(0.1, 10, [0, -1, 0])], SOFT)
    s.scene = replace(s.scene, wind=Wind((0.4, 0.0, 0.3), coefficients=coefficients))
    leant = s.run(1.5).axis
    edge = leant[-1] - leant[-5]
    angle = np.arctan2(np.hypot(edge[0], edge[2]), -edge[1])
    balance = root_scalar(lambda a: drag(0.5 * np.cos(a)) - WEIGHT * np.sin(a), bracket=(0.01, 1.5)).root
    assert angle == pytest.approx(balance, rel=0.01)
    assert edge[2] / edge[0] == pytest.approx(0.75, rel=0.02)
