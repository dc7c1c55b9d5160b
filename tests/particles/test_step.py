"""A step is that of a spring, of a pendulum, and of a weight on a slope."""

import numpy as np
import pytest

from hairpipe.particles.contact import Planes
from hairpipe.particles.model import Links, Model, Moving
from hairpipe.particles.step import Forces, Springs, advance

MASS, GRAVITY, LENGTH, AXIAL = 5e-5, 9.81, 0.1, 0.2
"""Of one particle that hangs on a root."""
STIFFNESS = AXIAL / LENGTH
FAR = 1.0


class Pendulum:
    """A particle on one link, whose root stands still; friction and a plane for it."""

    def __init__(
        self, way=(0.0, -LENGTH, 0.0), damping=0.0, drag=0.0, linked=1.0, normal=(0.0, 0.0, 0.0), friction=0.0
    ):
        ends, one = np.array([[0, 1]], np.int32), np.ones(1)
        links = Links(
            ends,
            LENGTH * one,
            linked * one,
            LENGTH * one,
            np.array([[1.0, 1.0]]),
            np.array([0, 1, 2], np.int32),
            np.array([0, 2], np.int32),
            np.array([1, 0], np.int32),
            np.array([0, 0], np.int32),
        )
        self.model = Model(1, np.full(2, MASS), np.ones(2), links, LENGTH, LENGTH, 1.0)
        self.springs = Springs(np.full(2, AXIAL), LENGTH * one, damping)
        self.forces = Forces(np.array([[0.0, -MASS * GRAVITY, 0.0]] * 2), np.zeros((2, 6)))
        self.forces.drag[:, [0, 3, 5]] = drag * MASS
        normals = np.array([[0.0, 0.0, 0.0], normal])
        offset = 0.0 if any(normal) else FAR
        self.planes = Planes(normals, np.array([FAR, offset]), np.zeros((2, 3)), np.zeros(2), friction)
        self.moving = Moving(np.array([[0.0, 0.0, 0.0], way], float), np.zeros((2, 3)), np.zeros(1))

    def run(self, seconds, dt):
        steps = round(seconds / dt)
        advance(self.model, self.springs, self.forces, self.planes, np.zeros((steps + 1, 1, 3)), dt, self.moving)
        return self.moving.points[1]


def test_hanging_particles_rest_at_the_stretch_of_their_weight():
    """The half of the stiffness that its own side gives it is all there is: the root's is the other half."""
    hung = Pendulum(drag=20.0)
    point = hung.run(4.0, 1 / 24)
    assert point == pytest.approx([0.0, -LENGTH - MASS * GRAVITY / STIFFNESS, 0.0], abs=1e-6)
    assert hung.moving.tensions == pytest.approx([MASS * GRAVITY], rel=1e-2)


def test_it_swings_as_a_stiff_pendulum_does_and_better_in_proportion_to_the_step():
    def theory(angle, seconds, dt=1e-5):
        rate, total = 0.0, 0.0
        while total < seconds - 0.5 * dt:
            rate -= dt * GRAVITY / LENGTH * np.sin(angle)
            angle += dt * rate
            total += dt
        return LENGTH * np.array([np.sin(angle), -np.cos(angle), 0.0])

    stiff, expected = 1e4 * AXIAL, theory(0.5, 0.25)
    errors = []
    for dt in (1 / 480, 1 / 960, 1 / 1920):
        swung = Pendulum(LENGTH * np.array([np.sin(0.5), -np.cos(0.5), 0.0]))
        swung.springs = swung.springs._replace(axial=np.full(2, stiff))
        errors.append(np.linalg.norm(swung.run(0.25, dt) - expected))
    assert errors[0] < 0.05 * LENGTH
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.15) and errors[1] / errors[2] == pytest.approx(
        2.0, rel=0.15
    )


def test_drag_leaves_the_speed_of_free_fall_that_it_bears():
    fallen = Pendulum(linked=0.0, drag=3.0)
    fallen.run(10.0, 1 / 24)
    assert fallen.moving.velocities[1] == pytest.approx([0.0, -GRAVITY / 3.0, 0.0], rel=1e-3)


@pytest.mark.parametrize(("friction", "slides"), [(0.5, False), (0.6, False), (0.3, True), (0.0, True)])
def test_on_a_slope_it_slides_where_friction_is_too_little_as_coulomb_says(friction, slides):
    """A slope of 25 deg, tan 25 deg = 0.466: at rest within the creep, or a = g (sin - mu cos)."""
    angle, seconds = np.deg2rad(25.0), 0.5
    weight = Pendulum((0.0, 0.0, 0.0), linked=0.0, normal=(np.sin(angle), np.cos(angle), 0.0), friction=friction)
    weight.moving.points[1] = 0.0
    weight.run(seconds, 1 / 96)
    down = np.array([np.cos(angle), -np.sin(angle), 0.0])
    speed, along = weight.moving.velocities[1] @ down, weight.moving.points[1] @ down
    assert abs(weight.moving.points[1] @ weight.planes.normals[1]) < 1e-9
    if slides:
        assert speed == pytest.approx(GRAVITY * (np.sin(angle) - friction * np.cos(angle)) * seconds, rel=0.01)
    else:
        assert 0.0 <= along < 1e-4 and speed < 2e-4


def test_hair_against_a_body_hangs_from_its_root():
    """A wall beside the root keeps it off the plumb line: the pendulum leans on it, at rest."""
    wall = 0.03
    leaning = Pendulum((0.05, -0.08, 0.0), normal=(1.0, 0.0, 0.0), damping=0.2, drag=5.0)
    leaning.planes.offsets[1] = -wall
    point = leaning.run(3.0, 1 / 24)
    tension = MASS * GRAVITY / -point[1] * np.linalg.norm(point)
    assert point[0] == pytest.approx(wall, abs=1e-6)
    assert np.linalg.norm(point) == pytest.approx(LENGTH + tension / STIFFNESS, rel=1e-4)
