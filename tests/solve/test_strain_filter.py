"""What puts strands right after a step changes their forces; the next step must not go by those that were."""

import numpy as np
import pytest

from hairpipe.laws.settings import Scheme
from hairpipe.shot.build import integrator_of
from hairpipe.solve.boundary import ClampPath, clamp_at
from hairpipe.solve.interactions import Interaction
from hairpipe.solve.stage import State, Step
from hairpipe.solve.stretch import LENGTH_JUMP, StrainFilter, mark_length_jumps
from hairpipe.solve.surroundings import Surroundings

FRAME = 1 / 24


def _two(scene, straight, **how):
    return scene([straight(0.1, 12, [0, -1, 0]), straight(0.1, 12, [1, -1, 0])], **how)


def _pull(shot, x, lane, part):
    """Draw the last point of a strand out along its segment by a part of that."""
    axis = shot.hair.layout.axis(x).reshape(2, -1, 3)[lane]
    x[-1, :, lane] += part * (axis[-1] - axis[-2])


@pytest.mark.parametrize("model", ["network", "chain"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_strands_of_which_a_segment_changed_its_length_are_marked(scene, straight, model, sign):
    shot = _two(scene, straight, model=model)
    before, after = shot.state.positions, shot.state.positions.copy()
    _pull(shot, after, 0, 0.9 * sign * LENGTH_JUMP)
    _pull(shot, after, 1, 1.1 * sign * LENGTH_JUMP)
    marks = np.zeros(shot.hair.layout.strands.shape, shot.hair.layout.dtype)
    mark_length_jumps(shot.hair.model, before, after, marks)
    np.testing.assert_array_equal(marks[0, :2], [0.0, 1.0])


def test_rotation_about_the_root_is_not_an_acceleration(scene, straight):
    shot = _two(scene, straight)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    before = shot.state.positions
    marks = np.zeros(shot.hair.layout.strands.shape, shot.hair.layout.dtype)
    mark_length_jumps(shot.hair.model, before, np.einsum("ij,pjw->piw", turn, before), marks)
    assert not marks.any()


@pytest.mark.parametrize("value", ["tr_bdf2", "bdf2"])
def test_stretched_strands_restart(scene, straight, value):
    """And the other strand goes on with its own."""
    shot = _two(scene, straight, scheme=Scheme(value=value))

    class Pulling(Interaction):
        in_solve = False

        def correct(self, end):
            _pull(shot, end.x, 1, 0.01)

    state, hair = shot.state, shot.hair
    motion = State.begin(state, state.positions)
    around = Surroundings(hair.model, hair.layout, [StrainFilter(hair.model, 0.1), Pulling()])
    held = clamp_at(shot.body, hair.groom, hair.rest, hair.layout)
    integrator = integrator_of(shot.scene)
    for time in (0.0, FRAME / 8):
        integrator.advance(hair.model, motion, Step(ClampPath(held, held, FRAME), time, FRAME / 8), around)
        assert motion.fresh[0, :2].tolist() == [False, True]
    assert np.isfinite(motion.x).all() and np.abs(motion.v).max() < 10.0
