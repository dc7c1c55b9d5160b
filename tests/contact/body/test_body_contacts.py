"""Hair on a ball: nothing inside, Coulomb's cone, and a soft start."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hairpipe.laws.settings import Scheme
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation

from ...strand_scenes import even_ball

CENTRE, RADIUS = np.array([0.04, -0.06, -0.0333]), 0.05


@pytest.fixture(scope="module")
def ball():
    return bake(even_ball(CENTRE, RADIUS, 600), 0.004, 6.0)


def still(surface):
    return [build_collider_field(surface, surface, 1 / 24, Interpolation.two_sided)]


def _depth(points):
    return RADIUS - np.linalg.norm(points - CENTRE, axis=1)


def test_hair_dropped_on_a_ball_stays_outside_and_comes_to_rest(scene, straight, ball):
    s = scene([straight(0.1, 20, [1, 0.1, 0.05 * k]) for k in range(-2, 3)], drag=5.0)
    for _ in range(30):
        s.run(1 / 24, bodies=still(ball))
        assert _depth(s.axis).max() < 1e-4
    assert _depth(s.axis).max() > -4e-3
    s.run(1.0, bodies=still(ball))
    assert np.abs(s.hair.layout.axis(s.state.velocities)).max() < 0.05


def test_hair_that_starts_inside_leaves_without_a_burst(scene, straight, ball):
    s = scene([straight(0.08, 16, [1, -0.7, 0])])
    assert _depth(s.axis).max() > 0.004
    fastest = 0.0
    for _ in range(24):
        s.run(1 / 24, bodies=still(ball))
        fastest = max(fastest, np.abs(s.state.velocities).max())
    assert _depth(s.axis).max() < 1e-3
    assert fastest < 5.0


@pytest.mark.parametrize("velocity", ["trapezoid", "full_step"])
def test_the_nine_steps_hold_what_lies_on_a_body(scene, straight, ball, velocity):
    """Else step 7 would give it what gravity and the hair that hangs down beside do in a step."""
    step = 1 / 240
    s = scene([straight(0.25, 50, [1, 0.1, 0])], step=step, drag=5.0, scheme=Scheme("nine_steps", velocity=velocity))
    for _ in range(12):
        s.run(1 / 24, bodies=still(ball))
    away = s.axis - CENTRE
    far = np.linalg.norm(away, axis=1)
    touching = far < RADIUS + 0.8e-3
    assert touching.sum() > 5
    speeds = np.sum(s.hair.layout.axis(s.state.velocities) * away, axis=1) / far
    assert np.abs(speeds[touching]).max() < 0.1 * 9.81 * step


def test_a_body_that_comes_carries_the_hair_away(scene, straight, ball):
    """At 0.5 m/s the ball goes by where the hair hangs."""
    s = scene([straight(0.1, 20, [0, -1, 0])])
    speed = np.array([0.5, 0.0, 0.0])
    moved = [replace(ball, origin=ball.origin + np.array([-0.1 + k * speed[0] / 24, 0, 0])) for k in range(8)]
    moving = [replace(m, velocity=np.full(m.velocity.shape, speed, np.float32)) for m in moved]
    for k in range(7):
        s.run(1 / 24, bodies=[build_collider_field(moving[k], moving[k + 1], 1 / 24, Interpolation.two_sided)])
        centre = CENTRE + np.array([-0.1 + (k + 1) * speed[0] / 24, 0, 0])
        assert (RADIUS - np.linalg.norm(s.axis - centre, axis=1)).max() < 5e-4


def test_a_body_that_comes_before_the_first_frame_has_no_hair_in_it_there(scene, straight, ball):
    """Pre-roll: it comes smoothly from 12 cm away in half a second. Else it has half of the hair in it."""
    hanging = [straight(0.1, 20, [0.1 * k, -1, 0]) for k in (-1, 0, 1)]
    at_once, led = scene(hanging), scene(hanging)
    assert (_depth(at_once.axis) > 1e-3).sum() > 20
    away = np.array([-0.12, 0.0, 0.0])
    share = np.linspace(0.0, 1.0, 13)
    moved = [replace(ball, origin=ball.origin + (1 - s * s * (3 - 2 * s)) * away) for s in share]
    rates = [-away * 6 * s * (1 - s) * 2.0 for s in share]
    moving = [
        replace(m, velocity=np.full(m.velocity.shape, rate, np.float32)) for m, rate in zip(moved, rates, strict=True)
    ]
    for before, after in pairwise(moving):
        led.run(1 / 24, bodies=[build_collider_field(before, after, 1 / 24, Interpolation.two_sided)])
    assert (_depth(led.axis) > 1e-3).sum() == 0
