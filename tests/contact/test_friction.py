"""Coulomb's law in the solve: what a sliding body pulls, and what a post lets through (Euler, Eytelwein)."""

import numpy as np
import pytest

from hairpipe.contact.body_implicit import _SLOW
from hairpipe.laws.settings import Air, BodyContact, Drag, Scheme, StepControl
from hairpipe.shot.settings import Scene
from hairpipe.strands.material import Material

from ..strand_scenes import Solid, around


def floor(height, speed):
    """The half space below a height, its surface moving along x."""
    return Solid(lambda x, _: (x[:, 1] - height, [0.0, 1.0, 0.0]), (speed, 0.0, 0.0), speed)


def post(centre, radius, speed):
    """A cylinder along z whose surface turns."""
    across = np.array([1.0, 1.0, 0.0])

    def shape(points, _):
        return around(points * across - [*centre, 0.0], radius)

    return Solid(shape, lambda x, t: speed * np.cross(shape(x, t)[1], [0.0, 0.0, 1.0]), speed)


def slope_at(point, slope):
    """The half space below a plane through a point that falls towards +z."""
    normal = np.array([0.0, 1.0, slope]) / np.hypot(1.0, slope)
    return Solid(lambda x, _: ((x - point) @ normal, normal))


@pytest.mark.parametrize(("slope", "sticks"), [(0.25, True), (0.6, False)])
def test_hair_lies_on_a_slope_or_slides_however_often_there_is_a_frame(scene, straight, slope, sticks):
    """Friction of 0.5. A frame goes on with the contact of the previous one: equal steps have the same motion."""
    ways = []
    for fps in (24.0, 4.0):
        shot = scene([straight(0.1, 20, [1, 0, 0])], model="chain", fps=fps)
        shot.scene = Scene(9.81, Air(Drag(8.0)), BodyContact(0.5, 0.0), steps=StepControl(1 / 96))
        before = shot.axis
        shot.run(1.0, [slope_at(before[0] - [0.0, 1e-6, 0.0], slope)])
        ways.append(np.linalg.norm(shot.axis[-1] - before[-1]))
    assert max(ways) < 5e-5 if sticks else min(ways) > 0.01
    assert ways[0] == pytest.approx(ways[1], rel=1e-6)


def test_without_friction_hair_that_lies_still_slides_from_the_first_step_on(scene, straight):
    shot = scene([straight(0.1, 20, [1, 0, 0])], model="chain", fps=96.0)
    shot.scene = Scene(9.81, Air(Drag(0.0)), BodyContact(0.0, 0.0), steps=StepControl(1 / 96))
    shot.run(1 / 96, [slope_at(shot.axis[0] - [0.0, 1e-6, 0.0], 0.6)])
    down = np.array([0.0, -0.6, 1.0]) / np.hypot(1.0, 0.6)
    tip = shot.hair.layout.axis(shot.state.velocities)[-1]
    assert tip @ down == pytest.approx(9.81 * 0.6 / np.hypot(1.0, 0.6) / 96, rel=0.02)


@pytest.mark.parametrize("steps", [240, 480])
def test_hair_that_begins_to_slide_speeds_up_like_a_block(block, steps):
    """At four percent more than the slope of its friction, less what the lag of friction takes in either stage."""
    pull, held = 9.81 * 0.52 / np.hypot(1.0, 0.52), 9.81 * 0.5 / np.hypot(1.0, 0.52)
    speeds = block(240).speeds(1 / steps, [(0.4, 0.5, 20), (0.52, 0.5, 5)])
    assert abs(speeds[19]) < 1e-5
    least, most = ((pull - held) / (1.0 + lag / steps * held / _SLOW) for lag in (0.5, np.sqrt(2.0) - 1.0))
    found = 240 * np.diff(speeds[22:])
    assert least < found.min() and found.max() < most


def test_friction_stops_hair_like_a_block(block):
    """Friction of 0.9 in place of 0.5: it stops after the time in which the difference of forces takes its speed."""
    speeds = block(480).speeds(1 / 480, [(0.4, 0.5, 40), (0.65, 0.5, 40), (0.65, 0.9, 60)])
    fastest, after = speeds[79], speeds[80:]
    stopped = round(480 * fastest * np.hypot(1.0, 0.65) / (9.81 * (0.9 - 0.65)))
    assert after.min() > -1e-3 * fastest
    assert after[stopped // 2] == pytest.approx(0.5 * fastest, rel=0.2)
    assert np.abs(after[stopped + 5 :]).max() < 1e-3 * fastest


def test_friction_does_not_turn_around_hair_that_had_sped_up(block):
    """Where gravity falls to a tenth, mu N of before would take more than its speed in a step."""
    block = block(480)
    speeds = block.speeds(1 / 480, [(0.4, 0.5, 40), (0.52, 0.5, 3)])
    after = block.speeds(1 / 480, [(0.52, 0.5, 10)], gravity=0.98)
    assert 5e-4 < speeds[42] < 0.8 * (0.5 - 0.52 / 10) * 9.81 / np.hypot(1.0, 0.52) / 480
    assert after.min() > 0.9 * speeds[42] and np.diff(after).min() > 0.0


@pytest.fixture
def block(scene, straight):
    return lambda fps: SoftHair(scene([straight(0.1, 20, [1, 0, 0])], Material(young=1e3), model="chain", fps=fps))


class SoftHair:
    """Hair across a slope, so soft that its tip moves as if it had no root."""

    def __init__(self, shot):
        self.shot = shot
        self.root = shot.axis[0]

    def speeds(self, seconds, phases, gravity=9.81):
        """Return the speed of the tip down the slope [m/s] after each frame of phases (slope, friction, frames)."""
        shot, speeds = self.shot, []
        for slope, friction, frames in phases:
            contact = BodyContact(friction)
            shot.scene = Scene(gravity, Air(Drag(0.0)), contact, steps=StepControl(seconds), strain=None)
            up = np.array([0.0, 1.0, slope]) / np.hypot(1.0, slope)
            plane = slope_at(self.root - (contact.thickness + 1e-6) * up, slope)
            down = np.array([0.0, -slope, 1.0]) / np.hypot(1.0, slope)
            for _ in range(frames):
                shot.run(shot.frame, [plane])
                speeds.append(shot.hair.layout.axis(shot.state.velocities)[-1] @ down)
        return np.array(speeds)


@pytest.mark.parametrize(
    "scheme",
    [
        Scheme(),
        Scheme("bdf2"),
        Scheme("backward_euler", "printed"),
        Scheme("nine_steps", "printed", "trapezoid"),
        Scheme("nine_steps", "printed", "full_step"),
    ],
)
def test_hair_and_what_it_lies_on_go_along_together(scene, straight, triangle, scheme):
    """At 1 m/s as at rest, whatever a frame begins with."""
    shot = scene([straight(0.1, 20, [1, 0, 0])], model="chain")
    shot.scene = Scene(9.81, Air(Drag(0.0)), BodyContact(0.5, 0.0), steps=StepControl(1 / 240), scheme=scheme)
    before, speed = shot.axis, np.array([1.0, 0.0, 0.0])
    shot.state.velocities[:] += speed[:, None]
    shot.body = triangle(velocities=np.tile(speed, (3, 1)))
    for frame in range(1, 7):
        body = triangle(triangle().points + frame / 24 * speed, np.tile(speed, (3, 1)))
        shot.run(1 / 24, [floor(before[0, 1] - 1e-6, 1.0)], body=lambda body=body: body)
    np.testing.assert_allclose(shot.axis - 0.25 * speed, before, atol=1e-4)


def settled(shot, body, friction, seconds, thickness=1e-4):
    """Run hair on a body; give the tension of the edge at its root, the mean over the last tenth of the time [N]."""
    shot.scene = Scene(9.81, Air(Drag(40.0)), BodyContact(friction, thickness), steps=StepControl(1 / 480))
    tensions = []
    for _ in range(round(24 * seconds)):
        shot.run(1 / 24, [body])
        tensions.append(shot.state.tensions[1, 0, 0])
    return np.mean(tensions[-len(tensions) // 10 :])


@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_a_floor_that_slides_under_hair_pulls_by_the_friction_of_its_weight(scene, straight, friction):
    strand = straight(0.1, 20, [1, 0, 0])
    shot = scene([strand], model="chain")
    pull = settled(shot, floor(-1e-6, 0.2), friction, 1.0, thickness=0.0)
    weight = 9.81 * shot.hair.model.mass[2:, 0].sum()
    # The root is held, and the drag of 40/s at most 2 % of the weight here.
    assert pull == pytest.approx(friction * weight, rel=0.05, abs=0.01 * weight)


@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_a_post_that_turns_lets_through_what_theory_says(scene, straight, friction):
    """Hair from its root over a quarter of a post, and down; T_root / T_free = exp(mu pi / 2)."""
    root = straight(0.1, 1, [1, 0, 0])[0]
    radius, level, hanging, segment = 0.02, 0.02, 0.12, 0.004
    turn = np.linspace(0, np.pi / 2, 50)[1:]
    arc = np.stack([level + radius * np.sin(turn), radius * np.cos(turn) - radius, 0 * turn], axis=1)
    path = np.concatenate([[[0, 0, 0], [level, 0, 0]], arc, [[level + radius, -radius - hanging, 0]]])
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    count = round(along[-1] / segment)
    shot = scene([straight(along[-1], count, [1, 0, 0])], Material(young=1e8), model="chain")
    bent = (
        np.stack([np.interp(np.linspace(0, along[-1], count + 1), along, path[:, c]) for c in range(3)], axis=1) + root
    )
    shot.state.positions[1:, :, :] = bent[:, :, None]
    centre = root[0] + level, root[1] - radius - 1e-4
    pull = settled(shot, post(centre, radius, 0.1), friction, 2.0)
    axis, mass = shot.axis, shot.hair.model.mass[1:, 0]
    free = axis[:, 0] > root[0] + level + radius - 1e-3
    below = 9.81 * mass[free & (axis[:, 1] < centre[1])].sum()
    # The weight of the hair on the post is pulled along, too: dT/da = mu T + rho g R (cos a + mu sin a ...)
    line = mass[5] / segment * 9.81
    a, tension = np.linspace(0, np.pi / 2, 2001), below
    for angle in a[::-1][:-1]:  # from the free side to the root; a from the top
        normal = tension + line * radius * np.cos(angle)
        tension += (friction * normal + line * radius * np.sin(angle)) * (a[1] - a[0])
    assert pull == pytest.approx(tension, rel=0.05)
