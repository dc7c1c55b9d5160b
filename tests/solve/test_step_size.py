"""Steps are as short as what moves asks for."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.laws.settings import StepControl
from hairpipe.shot.simulate import advance_frame
from hairpipe.solve.boundary import ClampPath, clamp_at
from hairpipe.solve.stage import State
from hairpipe.solve.step_size import CrossingLimit, Root, StrainRate, Travel, limits_of, next_step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.material import Material
from hairpipe.values import Mesh

FRAME = 1 / 24


class Around:
    """Surroundings of which only the speed of bodies counts."""

    def __init__(self, speed):
        self.speed = speed

    def fastest(self):
        return self.speed


def step(hair, body, distance=0.02):
    v = np.zeros((3, 3, 8))
    v[2, 1, 5] = hair
    motion = State(np.zeros_like(v), v, np.zeros_like(v), np.zeros((3, 3, 8)), np.zeros((1, 8), bool))
    nothing = np.zeros((1, 4, 3, 8))
    return next_step([Travel(distance, Around(body))], motion, ClampPath(nothing, nothing, FRAME), 0.0)


@pytest.mark.parametrize(("hair", "body", "steps"), [(0.0, 0.0, 1), (0.4, 0.1, 1), (1.2, 0.1, 3), (0.1, 1.9, 4)])
def test_neither_hair_nor_a_body_goes_farther_than_it_may(hair, body, steps):
    assert step(hair, body) == pytest.approx(FRAME / steps)


def test_strain_rate_is_that_of_edges_on_the_axis(scene, straight):
    shot = scene([straight(0.1, 4, (1.0, 0.0, 0.0))])
    model, stride = shot.hair.model, shot.hair.layout.shape.stride
    motion = State.begin(shot.state, shot.state.positions)
    motion.v[1] = [[5.0], [0.0], [0.0]]  # a perturbed particle: edges to it turn hair, and are none of the axis
    limit, path = StrainRate(model, 0.1), ClampPath(*2 * (np.zeros((1, 2, 3, 8)),), FRAME)
    assert stride == 2 and limit.longest(motion, path, 0.0) == np.inf
    motion.v[-1, 0] = 2.0
    assert limit.longest(motion, path, 0.0) == pytest.approx(0.1 * (0.1 / 4) / 2.0)


def held_at(shot, time, **tip):
    """The ends of a shot's hair, both carried along x at 2.4 m/s, the tip until it is let go of."""
    course = Track((0.0, 1.0), move=((0.0, 0.0, 0.0), (2.4, 0.0, 0.0)), ease="linear")
    ends = drive(shot.hair.groom, time, course, None, course, tip.get("release"))
    return clamp_at(ends, shot.hair.groom, shot.hair.rest, shot.hair.layout)


@pytest.mark.parametrize("release", [None, 0.5 + FRAME / 2])
@pytest.mark.parametrize("place", [0.0, 5.0])
def test_held_ends_go_as_far_as_they_may_wherever_they_are(scene, straight, release, place):
    """A tenth of a metre in a frame; a tip that is let go of in it asks for no step at all."""
    shot = scene([np.add(straight(0.1, 4, (1.0, 0.0, 0.0)), [0.0, place, 0.0])])
    path = ClampPath(*(held_at(shot, 0.5 + k * FRAME, release=release) for k in (0, 1)), FRAME)
    assert len(path.start.tips) and bool(path.held.any()) == (release is None)
    assert FRAME / Root(0.0101).longest(None, path, 0.0) == pytest.approx(10.0)


def test_segment_is_not_prescribed_at_both_ends(scene, straight):
    with pytest.raises(BadInput, match="one segment"):
        held_at(scene([straight(0.1, 4, (1.0, 0.0, 0.0)), straight(0.1, 1, (1.0, 0.0, 0.0))]), 0.0)


def test_courant_number_is_in_explicit_steps(scene, straight):
    """The sum over the springs at a particle by hand; a chain has edges and no other springs along it."""
    shot = scene([straight(0.1, 4, (1.0, 0.0, 0.0))], model="chain")
    model, limits = (
        shot.hair.model,
        limits_of(StepControl(courant=4.0), shot.hair.model, Surroundings(shot.hair.model, shot.hair.layout)),
    )
    edge = 4.0 * Material().axial / (0.1 / 4)
    masses = model.mass[model.shape.clamped :, 0]
    fastest = np.sqrt((edge * np.array([2.0, 2.0, 2.0, 1.0]) / masses).max())
    assert limits[-1].longest(None, None, 0.0) == pytest.approx(4.0 / fastest)


def settle(crossed, step=FRAME, most=FRAME, part=0.01, steps=100):
    """Go so many steps at the pace of hair of which a part, crossed(dt), would cross in a step of dt."""
    pace, taken = CrossingLimit(part, most, step), []
    for _ in range(steps):
        taken.append(pace.step)
        pace.follow(pace.step, crossed(pace.step))
    return taken


def test_steps_settle_where_few_enough_segments_cross():
    taken = settle(lambda dt: 0.03 * (dt / FRAME) ** 1.4)
    assert 0.03 * (taken[-1] / FRAME) ** 1.4 == pytest.approx(0.01, rel=1e-3)


def test_steps_are_as_long_as_they_may_be_where_nothing_crosses():
    assert settle(lambda dt: 0.0)[0] == settle(lambda dt: 0.0, step=FRAME / 4)[-1] == FRAME


def test_steps_get_no_shorter_than_a_quarter():
    taken = settle(lambda dt: 1.0)
    assert taken[1] == FRAME / 2
    assert taken[-1] == FRAME / 4


def test_other_causes_of_short_steps_do_not_bound_the_next():
    pace = CrossingLimit(0.01, FRAME, FRAME)
    pace.follow(FRAME / 10, 0.001)
    assert pace.step == FRAME


def jumping(shot, way):
    """Give the path of roots that go so far in a frame [m]."""
    bodies = (shot.body, Mesh(np.add(shot.body.points, [way, 0.0, 0.0]), shot.body.triangles))
    return ClampPath(*(clamp_at(body, shot.hair.groom, shot.hair.rest, shot.hair.layout) for body in bodies), FRAME)


@pytest.mark.parametrize("way", [0.003, 0.083, 1.7, 40.0])
def test_as_few_steps_are_taken_as_roots_need(scene, straight, way):
    """As counting from one finds, by looks that grow with the logarithm of the steps."""
    shot = scene([straight(0.1, 4, (1.0, 0.0, 0.0))])
    path, limit, looks = jumping(shot, way), Root(0.01), []
    ways = {}

    class Watched(ClampPath):
        def way(self, here, time):
            looks.append(time)
            return path.way(here, time)

    watched = Watched(path.start, path.end, FRAME)
    count = round(FRAME / limit.longest(None, watched, 0.0))
    assert len(looks) <= 2 * np.log2(count) + 3

    def farthest(n):
        found = path.way(path.ends(0.0), FRAME / n)
        return ways.setdefault(n, np.linalg.norm(found, axis=2).max())

    assert farthest(count) <= 0.01 and (count == 1 or farthest(count - 1) > 0.01)


def endless(scene, straight, steps, jump, speed):
    """Run a frame of two strands, the second twice as fine and moving, with some control of steps."""
    shot = scene([straight(0.1, 4, (1.0, 0.0, 0.0)), straight(0.1, 8, (1.0, 0.0, 0.0))])
    moved = Mesh(np.add(shot.body.points, [jump, 0.0, 0.0]), shot.body.triangles)
    shot.state.velocities[-1, 0, :] = speed
    control = replace(shot.scene, steps=steps)
    return advance_frame(shot.hair, shot.state, (shot.body, moved), (), FRAME, control)


@pytest.mark.parametrize(
    ("steps", "jump", "speed", "reported"),
    [
        (StepControl(courant=1e-300), 0.0, 0.0, "strand 1 needs more than 20,000 steps per frame by steps.courant"),
        (StepControl(strain_rate=1e-12), 0.0, 1.0, "strand 1 .* by steps.strain_rate = 1e-12"),
        (StepControl(strain_rate=1e-300), 0.0, 1.0, "strand 1 .* by steps.strain_rate = 1e-300"),
        (StepControl(), 1000.0, 0.0, "strand 0 .* by steps.root = 0.01"),
        (StepControl(travel=2e-5), 0.0, 100.0, "strand 1 .* by steps.travel = 2e-05"),
        (StepControl(longest=2e-6), 0.0, 0.0, "hair needs .* by steps.longest = 2e-06"),
        (StepControl(most=5), 0.0, 0.0, "hair needs more than 5 steps"),
    ],
)
def test_a_frame_that_would_never_end_is_ended_and_strand_and_setting_are_named(
    scene, straight, steps, jump, speed, reported
):
    with pytest.raises(ArithmeticError, match=reported):
        endless(scene, straight, steps, jump, speed)
