"""Hair held by a body at both ends: ponytails and ties."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.binding import bind_tips
from hairpipe.laws.settings import Construction, StepControl
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.solve.settle import settle_groom
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Mesh


def arc(segments=12):
    """Half a circle of 4 cm from the plate to the plate."""
    turn = np.linspace(0.0, np.pi, segments + 1)
    return np.array((0.03, 0.0, -0.03)) + 0.02 * np.column_stack([-np.cos(turn), np.sin(turn), 0.0 * turn])


def test_a_tip_goes_where_the_body_goes_and_a_free_one_does_not(triangle, scene):
    body = triangle()
    one = scene([arc(), arc()]).hair.groom
    groom = bind_tips(body, one, np.array([True, False]), 1.0)
    hair, rules = build_hair(groom, Material(), "network"), Scene(steps=StepControl(longest=1 / 96))
    state, frame, angle = start(hair, body, rules), 1 / 24, 0.6
    for number in range(1, 5):
        turn = angle * number / 24
        spin = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
        rate = angle * np.array([[-np.sin(turn), 0, np.cos(turn)], [0, 0, 0], [-np.cos(turn), 0, -np.sin(turn)]])
        after = Mesh(triangle().points @ spin.T, body.triangles, triangle().points @ rate.T)
        state = advance_frame(hair, state, (body, after), (), frame, rules)
        body = after
    moved = strands_of(hair, state).points.reshape(2, 13, 3)
    rest = groom.points.reshape(2, 13, 3)
    assert np.allclose(moved[:, 0], rest[:, 0] @ spin.T, atol=1e-6), "roots"
    assert np.allclose(moved[0, -2:], rest[0, -2:] @ spin.T, atol=1e-6), "the held tip, and where it points to"
    assert np.linalg.norm(moved[1, -1] - rest[1, -1] @ spin.T) > 1e-3


def test_without_a_body_a_held_tip_is_at_rest(triangle, scene):
    groom = bind_tips(triangle(), scene([arc()]).hair.groom, np.array([True]), 1.0)
    hair, rules = build_hair(groom, Material(), "network"), Scene(steps=StepControl(longest=1 / 96))
    state = advance_frame(hair, start(hair, None, rules), (None, None), (), 1 / 24, rules)
    assert np.allclose(strands_of(hair, state).points[-1], groom.points[-1], atol=1e-6)


def test_hair_held_at_its_tips_is_not_settled_as_if_it_were_free(triangle, scene):
    groom = bind_tips(triangle(), scene([arc()]).hair.groom, np.array([True]), 1.0)
    with pytest.raises(BadInput, match="tips held by the body would be released"):
        settle_groom(groom, Material(), Construction(), 9.81, "network")
