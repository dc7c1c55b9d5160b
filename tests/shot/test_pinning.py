"""Which points of hair are pinned, and to what."""

import numpy as np
import pytest

from hairpipe.body.shapes import build_cylinder
from hairpipe.errors import BadInput
from hairpipe.groom.sampling import joined_strands
from hairpipe.groom.strands import lay_strands
from hairpipe.shot.goals import check_mesh, pin
from hairpipe.solve.boundary import motion_of_sites


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
