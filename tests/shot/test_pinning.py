"""Which points of hair are pinned, and to what; hair held by a body at both ends."""

import numpy as np
import pytest

from hairpipe.body.shapes import build_cylinder
from hairpipe.errors import BadInput
from hairpipe.groom.binding import bind_tips
from hairpipe.groom.sampling import joined_strands
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import Construction, StepControl
from hairpipe.shot.goals import check_mesh, pin
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.solve.boundary import motion_of_sites
from hairpipe.solve.settle import settle_groom
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Mesh


@pytest.fixture
def groom():
    """Strands of 10 cm along x, of 10 segments and of 5, in groups of their own."""
    long, short = (lay_strands(2, 0.1, n, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0) for n in (10, 5))
    return joined_strands((long, short), ("tail", "fringe"))


def ball(x=0.05):
    """A small ball between the strands."""
    return build_cylinder(0.002, 0.0, True, 16, (x, 0.0, 0.005), (0.0, 0.0, 1.0))


def test_points_at_fractions_of_the_length_go_with_their_roots(groom):
    pinned = pin(groom, None, "tail", (0.28, 0.5), None, 0.01)
    np.testing.assert_allclose(pinned.rest[:, 0], [0.03, 0.05, 0.03, 0.05])
    np.testing.assert_array_equal(pinned.points, [3, 5, 14, 16])
    np.testing.assert_array_equal(pinned.frames, groom.root_frames[[0, 0, 1, 1]])


def test_without_fractions_the_point_nearest_to_the_body_is_pinned(groom):
    pinned = pin(groom, ball(), None, (), None, 0.1)
    np.testing.assert_allclose(pinned.rest[:2, 0], 0.05)
    assert len(pinned.points) == 4 and np.isin(pinned.rest[2:, 0].round(3), [0.04, 0.06]).all()


def test_a_tie_pins_the_point_of_each_strand_nearest_to_its_place(groom):
    pinned = pin(groom, None, None, (), (0.081, 0.02, 0.0), 0.01)
    np.testing.assert_allclose(pinned.rest[:, 0], 0.08)


def test_pinned_points_keep_their_place_on_a_moved_body(groom):
    rest, moved = ball(), ball(0.15)
    pinned = pin(groom, rest, "tail", (), None, 0.1)
    motions, _ = motion_of_sites(moved, *pinned.sites, pinned.frames)
    places = np.einsum("kij,kj->ki", motions[:, :, :3], pinned.rest) + motions[:, :, 3]
    np.testing.assert_allclose(places, pinned.rest + np.array([0.1, 0.0, 0.0]), atol=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"group": "beard"}, r"no group 'beard'.*'fringe', 'tail'"),
        ({"reach": 0.001}, r"away from the body: strands 0, 1.*reach"),
        ({"mesh": None}, "nothing states which points are pinned"),
    ],
)
def test_bad_pins_are_refused(groom, given, message):
    with pytest.raises(BadInput, match=message):
        pin(groom, **{"mesh": ball(), "group": "tail", "at": (), "place": None, "reach": 0.1, **given})


def test_another_body_is_refused(groom):
    pinned = pin(groom, ball(), "tail", (), None, 0.1)
    with pytest.raises(BadInput, match="pinned to triangle"):
        check_mesh(pinned, build_cylinder(0.002, 0.01, False, 8, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))


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
