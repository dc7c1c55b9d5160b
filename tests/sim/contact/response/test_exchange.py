"""What strands exchange in the solve: opposite to rounding, and all that they feel of each other."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.sim.catalogue import surroundings_of
from hairpipe.sim.contact import hair as contact
from hairpipe.sim.integrators.catalogue import integrator_of
from hairpipe.sim.motion import Motion, Step
from hairpipe.sim.roots import Path, hold
from hairpipe.sim.scene import Air, Collisions, Scene, Scheme, StepControl, Stiction

DT = 1 / 240
SCENE = Scene(
    gravity=0.0,
    air=Air(0.0),
    steps=StepControl(longest=DT),
    scheme=Scheme("backward_euler"),
    stiction=Stiction(reach=1e-3, release=3e-3),
    collisions=Collisions(thickness=8e-4),
)


class Gives:
    """Gives points impulses [N s], as a wind of which only the force is known."""

    def __init__(self, impulses):
        self.impulses = impulses

    def begin(self, points, offsets):
        pass

    def forces(self, points, felt, offsets, time, marked, push, damping):
        push[:] += self.impulses / DT


@pytest.fixture
def clash(scene, straight):
    """Throw two hairs at each other, in an orientation; give the surroundings and the velocities after one step."""

    def throw(turn, gives=None):
        root, across = straight(0.1, 1, [1, 0, 0])[0], np.array([0.0, 5e-4, 0.0])
        one = straight(0.1, 12, [1, 0, 0.1])
        other = one[::-1] * [1, 1, -1] + [0, 0, 2 * root[2]] + across
        shot = scene([(strand - root) @ turn.T + root for strand in (one, other)])
        state, offsets = shot.state, shot.hair.layout.offsets
        fast = turn @ [0.0, 1.0, 0.0]
        state.velocities[3:, :, :2] += (np.multiply.outer(fast, [0.5, -1.0]))[None]
        around = surroundings_of(shot.hair, shot.hair.model, state, [], SCENE, 0.0)
        if gives is not None:
            around.hair, around.wind = None, Gives(gives)
        motion = Motion(state.positions, state.velocities, state.accelerations, state.tensions)
        held = [hold(shot.body, shot.hair.groom, shot.hair.rest, shot.hair.layout)] * 2
        integrator_of(SCENE).advance(shot.hair.model, motion, Step(Path(*held, DT), 0.0, DT), around)
        return around, shot.hair.layout.axis(motion.v), offsets

    return throw


@pytest.mark.parametrize("tolerance", [None, 0.9])
@pytest.mark.parametrize("seed", range(4))
def test_two_hairs_get_opposite_impulses_however_early_the_solve_ends(clash, monkeypatch, seed, tolerance):
    if tolerance is not None:
        monkeypatch.setattr(contact, "_TOLERANCE", tolerance)
    around, _, offsets = clash(Rotation.random(random_state=seed).as_matrix())
    received = around._memory["received"].copy()
    one, other = received[: offsets[1]].sum(axis=0), received[offsets[1] :].sum(axis=0)
    assert np.abs(received).max() > 1e-9
    np.testing.assert_allclose(one, -other, rtol=0, atol=1e-12 * np.linalg.norm(one))


def test_hair_goes_as_it_would_alone_with_the_impulses_it_got(clash):
    turn = Rotation.random(random_state=1).as_matrix()
    around, after, _ = clash(turn)
    _, alone, _ = clash(turn, around._memory["received"])
    _, free, _ = clash(turn, np.zeros_like(alone))
    assert np.abs(alone - free).max() > 0.1
    np.testing.assert_allclose(after, alone, atol=1e-9)
