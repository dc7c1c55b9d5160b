"""A step is solved as a dense system is, and is that of a spring, of a pendulum, and of a weight on a slope."""

import numpy as np
import pytest

from hairpipe.particles.contact import Planes
from hairpipe.particles.model import Links, Model, Moving, build_model
from hairpipe.particles.solve import build_system, hold, set_blocks, solve, take_off
from hairpipe.particles.step import Forces, Springs, advance

HELD = {3: (0.0, 0.6, 0.8), 20: (1.0, 0.0, 0.0)}
"""Of those that are free: along what they are held."""
DAMPER = 0.5


def blocks_of(matrix, k):
    return matrix[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]


@pytest.fixture
def systems(particles):
    """The system of the particles' links with random numbers, and the same as a dense matrix."""
    links, deep, rng = build_model(particles).links, int(np.sum(particles.arcs < 0.0)), np.random.default_rng(2)
    count, system = len(particles.points), build_system(links, deep)
    joins = rng.normal(size=(len(links.ends), 4))
    joins[:, 3] **= 2
    system.joins[:] = joins[links.by].ravel()
    matrix = 0.1 * np.eye(3 * count)
    for (i, j), join in zip(links.ends, joins, strict=True):
        pull = np.outer(join[:3], join[:3]) + join[3] * np.eye(3)
        for a, b, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
            matrix[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * pull
    set_blocks(system, np.array([blocks_of(matrix, k)[np.triu_indices(3)] for k in range(count)]))
    return system, matrix, deep


def filled(vectors):
    return np.pad(vectors, ((0, 0), (0, 1))).astype(np.float32).ravel()


def test_the_solution_and_the_residual_equal_those_of_the_dense_matrix(systems):
    system, matrix, deep = systems
    count, rng = len(matrix) // 3, np.random.default_rng(3)
    pushes = rng.normal(size=(count, 3))
    pushes[:deep] = 0.0
    change, residual = np.zeros(4 * count, np.float32), filled(pushes)
    assert 5 < solve(system, residual, change, 1e-6, 0.0) < 200
    free = matrix[3 * deep :, 3 * deep :]
    expected = np.linalg.solve(free, pushes[deep:].ravel()).reshape(-1, 3)
    found = change.reshape(-1, 4)[deep:]
    assert found[:, :3] == pytest.approx(expected, abs=1e-4 * np.abs(expected).max()) and not found[:, 3].any()
    take_off(system, change, residual)
    left = pushes[deep:].ravel() - free @ found[:, :3].astype(float).ravel()
    assert residual.reshape(-1, 4)[deep:, :3].ravel() == pytest.approx(left, abs=1e-4)


def test_held_particles_are_fixed_along_the_normal_and_damped_across_it(systems):
    system, matrix, deep = systems
    count = len(matrix) // 3
    pushes = np.random.default_rng(4).normal(size=(count, 3))
    pushes[:deep] = 0.0
    for k, normal in HELD.items():
        n, k = np.array(normal), deep + k
        hold(system, k, tuple(n), DAMPER)
        across = np.eye(3) - np.outer(n, n)
        matrix[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += DAMPER * np.eye(3)
        pushes[k] = across @ pushes[k]
        for columns in (matrix, matrix.T):
            columns[3 * k : 3 * k + 3] = across @ columns[3 * k : 3 * k + 3]
        blocks_of(matrix, k)[:] += np.outer(n, n)
    change = np.zeros(4 * count, np.float32)
    solve(system, filled(pushes), change, 1e-6, 0.0)
    expected = np.linalg.solve(matrix[3 * deep :, 3 * deep :], pushes[deep:].ravel()).reshape(-1, 3)
    found = change.reshape(-1, 4)[deep:, :3]
    assert found == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
    assert all(abs(found[k] @ normal) < 1e-6 for k, normal in HELD.items())


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
