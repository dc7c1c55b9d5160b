"""A frame of hair against rod theory and against the laws every step must keep."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import Collisions
from hairpipe.measure.motion import root_places
from hairpipe.solve.boundary import motion_of_roots

G = 9.81


@pytest.mark.parametrize("step", [6e-4, 1 / 240, 1 / 120, 1 / 24])
def test_hanging_hair_stays_at_rest_at_any_step(scene, straight, step):
    """Row 8 of the acceptance table: the printed spring diverges above 3.5 ms."""
    s = scene([straight(0.3, 50, [0, -1, 0])], step=step).run(1.0)
    lengths = np.linalg.norm(np.diff(s.axis, axis=0), axis=1) / 0.006
    assert np.abs(lengths - 1).max() < 3e-4
    assert np.abs(s.state.velocities).max() < 0.01


def test_swing_keeps_its_energy(scene, straight):
    """Without drag the only loss is the integrator's: under 5 % in a second at 1/240 s."""
    s = scene([straight(0.3, 50, [np.sin(1), -np.cos(1), 0])])
    start = _energy(s)
    assert abs(_energy(s.run(1.0)) / start - 1) < 0.05


def _energy(scene):
    """Kinetic energy and weight above the hanging position; the springs' share is small in a swing."""
    mass = scene.hair.model.mass[:, 0][3:]
    x, v = scene.state.positions[3:, :, 0], scene.state.velocities[3:, :, 0]
    hanging = scene.hair.rest[2, 1, 0] - np.linalg.norm(scene.hair.rest[3:, :, 0] - scene.hair.rest[2, :, 0], axis=1)
    return np.sum(mass * (0.5 * np.sum(v**2, axis=1) + G * (x[:, 1] - hanging)))


def test_weightless_groom_on_a_still_body_does_not_move(scene):
    curl = np.stack(
        [0.01 * np.cos(np.arange(26) * 0.7), -0.004 * np.arange(26.0), 0.01 * np.sin(np.arange(26) * 0.7)], axis=1
    )
    s = scene([curl], gravity=0.0)
    before = s.axis
    np.testing.assert_allclose(s.run(0.5).axis, before, atol=1e-12)


def test_hair_moves_rigidly_with_a_body_in_free_translation(scene, straight, triangle):
    """Galilean invariance: a body that always moved at this speed carries its hair along unchanged."""
    speed = np.array([0.7, 0.0, -0.4])
    still = scene([straight(0.1, 10, [0.3, -1, 0])])
    moving = scene([straight(0.1, 10, [0.3, -1, 0])])
    clock = [0]

    def body():
        clock[0] += 1
        at = clock[0] / 24
        return triangle(triangle().points + at * speed, np.tile(speed, (3, 1)))

    from hairpipe.shot.simulate import start

    moving.body = triangle(velocities=np.tile(speed, (3, 1)))
    moving.state = start(moving.hair, moving.body, moving.scene)
    still.run(0.5)
    moving.run(0.5, body=body)
    np.testing.assert_allclose(moving.axis - clock[0] / 24 * speed, still.axis, atol=1e-6)


def test_a_strand_does_not_depend_on_its_neighbours_or_on_threads(scene, straight, same_on_threads):
    strands = [straight(0.02 * k, 10 if k % 3 else 7, [1, -0.1 * k, 0.05 * k]) for k in range(1, 14)]
    together = same_on_threads(lambda: scene(strands).run(0.125).axis)
    np.testing.assert_array_equal(together, np.concatenate([scene([s]).run(0.125).axis for s in strands]))
    backwards = scene(strands[::-1]).run(0.125)
    parts = [backwards.axis[a:b] for a, b in pairwise(backwards.hair.layout.offsets)]
    np.testing.assert_array_equal(together, np.concatenate(parts[::-1]))


@pytest.mark.parametrize("touching", [{}, {"collisions": Collisions()}])
def test_a_strand_that_is_not_finite_starts_as_groomed_and_spares_the_others(scene, straight, touching):
    """Those are 10 cm apart; the last of them is bent, and goes on as it is."""
    strands = [straight(0.1, 10, [1, 0, 0]) + np.array([0.0, 0.0, 0.1 * k]) for k in range(3)]
    shots = [scene(strands).run(1 / 24) for _ in range(2)]
    for shot in shots:
        shot.scene = replace(shot.scene, **touching)
    shots[1].state.positions[5, 0, 1] = np.nan
    with pytest.warns(UserWarning, match=r"1 strands were not finite before frame 1 .*: strands 1$"):
        shots[1].run(1 / 24)
    good = shots[0].run(1 / 24)
    np.testing.assert_array_equal(shots[1].axis[:11], good.axis[:11])
    np.testing.assert_array_equal(shots[1].axis[22:], good.axis[22:])
    fallen = scene(strands).run(1 / 24).axis
    np.testing.assert_allclose(shots[1].axis[11:22], fallen[11:22], atol=1e-4)


def test_a_strand_whose_root_is_not_finite_is_named(scene, straight):
    shot = scene([straight(0.1, 10, [1, 0, 0]) for _ in range(3)])
    shot.state.positions[:, :, 1] = np.nan
    with pytest.raises(ArithmeticError, match=r"ids 1$"):
        _ = shot.points


@pytest.mark.parametrize("wrong", [0.0, np.nan])
def test_a_strand_with_a_segment_of_no_length_is_refused_by_name(scene, straight, wrong):
    strands = [straight(0.1, 10, [1, 0, 0]) for _ in range(3)]
    strands[1][4] = strands[1][3] + wrong
    with pytest.raises(BadInput, match=r"strands 1 \("):
        scene(strands)


def test_a_groom_of_another_body_is_refused(scene, straight, triangle):
    groom = scene([straight(0.1, 10, [1, 0, 0])]).hair.groom
    other = replace(groom, root_triangles=groom.root_triangles + 1)
    for place in (motion_of_roots, lambda driver, groom: root_places(groom, driver)):
        place(triangle(), groom)
        with pytest.raises(BadInput, match=r"in\.body: hair grows from triangle 1 of a body that has 1 "):
            place(triangle(), other)


@pytest.mark.parametrize("strands", [1, 3])
def test_ends_of_another_groom_are_refused(strands):
    two, others = (lay_strands(n, 0.1, 10, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0) for n in (2, strands))
    ends = drive(others, 0.0, Track(), None, None, None)
    for place in (motion_of_roots, lambda driver, groom: root_places(groom, driver)):
        with pytest.raises(BadInput, match=f"in.ends: ends of {strands} strands, the groom has 2"):
            place(ends, two)
