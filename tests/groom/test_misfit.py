"""Each cause for which roots lie off a body is told from the others, and none is told where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.groom.binding import cause_of_misfit
from hairpipe.groom.importing import adopt
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import SHORTEST
from hairpipe.values.groom import Curves

REACH, TWICE = 0.01, np.array([0, 0.4, 0.2])
DOWN = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.fixture
def head(ball):
    """A head that is higher than wide, a metre above the origin and before it."""
    return replace(ball.mesh, points=ball.mesh.points * [1.0, 1.4, 1.2] + [0.0, 1.0, 0.3])


@pytest.fixture
def hair(head):
    """Roots on the upper half of the head, and tips 0.1 m above them."""
    corners = head.points[head.triangles]
    upper = corners.mean(axis=1)[corners.mean(axis=1)[:, 1] > 1.0]
    return upper, upper + np.array([0.02, 0.1, 0.03])


WRONG = {
    "tip first": (lambda roots, tips: (tips, roots), "the other ends lie on it"),
    "centimetres": (lambda roots, tips: (100 * roots, 100 * tips), "hair is in units of 1 cm, the body in metres"),
    "metres": (lambda roots, tips: (roots / 100, tips / 100), "the body is in units of 1 cm, hair in metres"),
    "feet": (lambda roots, tips: (roots / 0.3048, tips / 0.3048), "hair is in units of 1 foot, the body in metres"),
    "z up": (lambda roots, tips: (roots @ DOWN, tips @ DOWN), "hair has Z up in place of Y"),
    "z up in inches": (
        lambda roots, tips: (roots @ DOWN / 0.0254, tips @ DOWN / 0.0254),
        "hair is in units of 1 inch, the body in metres, and hair has Z up in place of Y",
    ),
    "moved twice": (lambda roots, tips: (roots + TWICE, tips + TWICE), "displaced by one vector"),
    "moved far": (lambda roots, tips: (roots - [3.0, 2.0, 1.0], tips - [3.0, 2.0, 1.0]), "displaced by one vector"),
}


@pytest.mark.parametrize(("change", "message"), WRONG.values(), ids=WRONG)
def test_causes_are_distinguished(head, hair, change, message):
    cause = cause_of_misfit(head, *change(*hair), REACH)
    assert cause is not None and message in cause.what


def test_no_cause_is_made_up(head, hair):
    turn = Rotation.from_rotvec([0.0, 0.0, 0.9]).as_matrix()
    assert cause_of_misfit(head, *(3.7 * ends @ turn for ends in hair), REACH) is None


def test_different_times_are_reported(ball):
    out = np.eye(3) * 0.5
    points = np.stack([out, 1.1 * out], axis=1).reshape(-1, 3)
    known = np.arange(3, dtype=np.int32), np.zeros(3, bool), np.zeros(3, np.int64)
    curves = Curves(points, np.array([0, 2, 4, 6], np.int32), *known, time=1002.0)
    for body, when in ((ball, "at rest"), (replace(ball, time=1000.0), "at time code 1000")):
        with pytest.raises(BadInput, match=f"body is read {when}, the moving hair at time code 1002"):
            adopt(body, curves, cut=Cut(None, None, SHORTEST), strands=None, reach=REACH)
