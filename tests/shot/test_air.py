"""Wind and still air, through the whole solver, against balances of forces."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import root_scalar

from hairpipe.laws.settings import Air, Coefficients, Drag, Scheme, StepControl, Wind
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
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


LIMP = Material(young=1e7, softening=1.0)
SPEED = 0.5


def dragged(shot, drag, factors, model):
    """Give the strands of a shot a drag times a factor each, by a map."""
    groom = replace(shot.hair.groom, maps={"air": np.array(factors)})
    shot.hair = build_hair(groom, Material(), model)
    shot.scene = replace(shot.scene, air=Air(Drag(drag, map="air")))
    shot.state = start(shot.hair, shot.body, shot.scene)
    return shot


@pytest.mark.parametrize(
    ("model", "scheme"),
    [
        ("rod", Scheme()),
        ("rod", Scheme("bdf2")),
        ("chain", Scheme("backward_euler")),
        ("network", Scheme("nine_steps")),
    ],
)
def test_two_strands_of_different_drag_are_each_that_strand_alone(scene, straight, model, scheme):
    line = straight(0.1, 10, [1, 0, 0])
    both = dragged(scene([line, line], model=model, scheme=scheme), 30.0, (1.0, 0.1), model)
    both = both.run(0.125).axis.reshape(2, -1, 3)
    for found, rate in zip(both, (30.0, 3.0), strict=True):
        alone = scene([line], drag=rate, model=model, scheme=scheme).run(0.125).axis
        # A network has half of its mass between points, which this drag moves to them; other schemes begin otherwise.
        most = {"rod": 5e-5, "chain": 1e-9, "network": 2e-4}[model]
        np.testing.assert_allclose(found, alone, rtol=0, atol=most)
    assert np.linalg.norm(both[0, -1] - both[1, -1]) > 5e-3


def test_towed_hair_leans_by_the_drag_beyond_each_place(scene, straight, triangle):
    """A limp hair behind a root at constant speed: its slope is V r / g, with the mean r of the rates beyond."""
    shot = scene([straight(0.1, 20, [0, -1, 0])], LIMP, model="rod")
    shot.scene = replace(shot.scene, air=Air(Drag(20.0, profile=((0.0, 0.0), (1.0, 1.0)))))
    moved, still = [0.0], triangle().points

    def on():
        moved[0] += SPEED * shot.frame
        return triangle(still + np.array([moved[0], 0.0, 0.0]), np.tile([SPEED, 0.0, 0.0], (3, 1)))

    shot.body = triangle(still, np.tile([SPEED, 0.0, 0.0], (3, 1)))
    shot.state = start(shot.hair, shot.body, shot.scene)
    edges = np.diff(shot.run(4.0, body=on).axis, axis=0)
    beyond = 0.5 * (1.0 + (np.arange(20) + 0.5) / 20)  # the mean of a rate that grows linearly to the tip
    found = -edges[4:-1, 0] / -edges[4:-1, 1]
    np.testing.assert_allclose(found, (SPEED * 20.0 * beyond / 9.81)[4:-1], rtol=0.02)


def test_small_swings_decay_by_half_of_their_rates(scene, straight):
    """Drag damps every mode of hair alike, by exp(-r t / 2): so much larger is the swing of a strand without drag."""
    shot = dragged(scene([straight(0.1, 10, [0, -1, 0])] * 3, model="rod"), 2.0, (0.0, 0.5, 1.0), "rod")
    rates, (rest,) = np.array([0.0, 1.0, 2.0]), np.unique(shot.axis[::11, 0])
    velocities = shot.state.velocities.copy()
    velocities[:, 0] += 0.02 * (shot.axis[0, 1] - shot.state.positions[:, 1]).clip(0.0) / 0.1
    shot.state = replace(shot.state, velocities=velocities)
    tips = np.array([shot.run(1 / 24).axis[10::11, 0] - rest for _ in range(36)])
    grown = tips * np.exp(0.5 * rates * np.arange(1, 37)[:, None] / 24)
    most = np.abs(tips[:, 0]).max()
    assert np.abs(grown - grown[:, :1]).max() < 0.1 * most < 0.3 * np.abs(tips - tips[:, :1]).max()
