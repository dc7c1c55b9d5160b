"""A strand thrown about comes back; one that is not is left to the accurate scheme."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.laws.settings import Collisions, Scheme, StepControl, Stiction, Thickness
from hairpipe.strands.lattice import CLAMPED


@pytest.mark.parametrize("step", [1 / 1920, 1 / 240, 1 / 24])
def test_scattered_particles_come_back_without_a_burst(scene, straight, step):
    s = scene([straight(0.25, 25, [0.2, -1, 0.1])], step=step, drag=8.0)
    rng = np.random.default_rng(4)
    shape = s.state.positions[CLAMPED:, :, :1].shape
    s.state.positions[CLAMPED:] += rng.normal(scale=0.02, size=shape)
    s.run(1.0)
    lengths = np.linalg.norm(np.diff(s.axis, axis=0), axis=1) / 0.01
    assert np.abs(lengths - 1).max() < 0.02
    assert np.abs(s.state.velocities).max() < 20.0


def test_a_strand_out_of_reach_of_the_scheme_leaves_its_neighbour_alone(scene, straight):
    strands = [straight(0.1, 10, [1, 0, 0])] * 2
    steps = StepControl(travel=1.0)  # all strands share a step; let none shorten it
    calm, wild = scene(strands), scene(strands)
    calm.scene, wild.scene = replace(calm.scene, steps=steps), replace(wild.scene, steps=steps)
    wild.state.positions[CLAMPED:, :, 1] += np.random.default_rng(5).normal(scale=0.02, size=(20, 3))
    np.testing.assert_array_equal(wild.run(1 / 24).axis[:11], calm.run(1 / 24).axis[:11])


@pytest.mark.parametrize(("stretched", "guarded"), [(1.3, False), (1.0, True)])
@pytest.mark.parametrize("touching", [False, True])
def test_lost_strands_move_with_their_head(scene, straight, triangle, touching, stretched, guarded):
    """A step at rest and one at 2 m/s end alike, for a strand that is done again or foretold too far, and beside it."""
    tuft = [straight(0.1, 10, [1, -0.3, 0]) + np.array([0.0, 0.0, 4e-4 * k]) for k in range(3)]
    ends = []
    for speed in (np.zeros(3), np.array([0.0, 0.0, 2.0])):
        s = scene(tuft, fps=96.0)
        limits = {"steps": StepControl(longest=1 / 96, travel=1.0, root=1.0), "strain": None}
        hair = {"stiction": Stiction(1e-3, 3e-3), "collisions": Collisions(Thickness(3e-4))} if touching else {}
        s.scene = replace(s.scene, **limits, **hair)
        x, v = s.state.positions, s.state.velocities
        x[CLAMPED:, :, 1] = x[2, :, 1] + stretched * (x[CLAMPED:, :, 1] - x[2, :, 1])
        v += speed[:, None]
        v[-6:, 1, 1] += 8.0 * guarded
        s.body = triangle(velocities=np.tile(speed, (3, 1)))
        after = triangle(triangle().points + speed / 96, np.tile(speed, (3, 1)))
        ends.append(s.run(1 / 96, body=lambda after=after: after).axis - speed / 96)
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-6)


def test_a_step_done_again_keeps_nothing_that_memory_held_before(scene, straight, monkeypatch):
    """States are stored, and the same on every run: also numbers that no spring uses."""
    states, new = [], np.empty_like
    for held in (0.0, 7.0):
        monkeypatch.setattr(np, "empty_like", lambda array, held=held: np.full_like(new(array), held))
        s = scene([straight(0.1, 10, [1, 0, 0])])
        s.state.positions[CLAMPED:, :, 0] += np.random.default_rng(5).normal(scale=0.02, size=(20, 3))
        states.append(s.run(1 / 24).state)
    for one, other in zip(*(vars(state).values() for state in states), strict=True):
        np.testing.assert_array_equal(one, other)


def test_square_wave_of_the_root_stays_bounded(scene, straight, triangle):
    """+-2 m/s, turned round ten times a second, at one step per frame."""
    s = scene([straight(0.3, 30, [0, -1, 0])], step=1 / 24, drag=8.0)
    clock = [0]

    def body():
        clock[0] += 1
        ahead = 1 if (clock[0] // 3) % 2 else -1
        shift = 0.08 * (clock[0] % 3 if ahead > 0 else 3 - clock[0] % 3)
        return triangle(triangle().points + np.array([shift, 0, 0]), np.tile([2.0 * ahead, 0, 0], (3, 1)))

    for _ in range(48):
        s.run(1 / 24, body=body)
        assert np.isfinite(s.axis).all()
        assert (np.linalg.norm(np.diff(s.axis, axis=0), axis=1) / 0.01).max() < 1.03


def test_backward_euler_takes_energy_only_out(scene, straight):
    """Free fall is exact to first order; a swing loses height."""
    scheme = Scheme(value="backward_euler", spring="tension")
    s = scene([straight(0.1, 10, [1, -1, 0])], fps=240.0, scheme=scheme)
    mass, top = s.hair.model.mass[CLAMPED:, 0], s.state.positions[CLAMPED:, 1, 0].copy()
    for _ in range(200):
        s.run(1 / 240)
        x, v = s.state.positions[CLAMPED:, :, 0], s.state.velocities[CLAMPED:, :, 0]
        kinetic = 0.5 * np.sum(mass * np.sum(v**2, axis=1))
        assert kinetic <= 9.81 * np.sum(mass * (top - x[:, 1])) * 1.001
