"""Strands as rods at rest."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.droop_rod import droop_rod
from hairpipe.groom.sampling import joined_strands
from hairpipe.groom.strands import lay_strands
from hairpipe.strands.material import Material

ASIDE, DOWN = (0.6, 0.0, 0.8), (0.0, -1.0, 0.0)


def laid(direction, length=0.03, segments=200):
    return lay_strands(1, length, segments, direction, (0.0, 0.0, 0.0), None, 0.0)


def test_little_weight_bends_as_a_beam():
    """The tip of a cantilever under its weight: q L^4 / (8 E I)."""
    material = Material()
    hair = droop_rod(laid(ASIDE), material=material)
    deflection = material.line_density * 9.81 * 0.03**4 / (8 * material.bending)
    assert hair.points[-1, 1] == pytest.approx(-deflection, rel=0.01)
    assert hair.points[-1, 0] / hair.points[-1, 2] == pytest.approx(0.75, rel=1e-5)


def test_its_length_and_its_clamp_are_those_of_the_groom():
    groom = joined_strands((laid(ASIDE, 0.3), laid((0.0, 0.5, 1.0), 0.1)))
    hair = droop_rod(groom)
    for first, last in zip(groom.offsets, groom.offsets[1:], strict=False):
        ours, theirs = hair.points[first:last].astype(float), groom.points[first:last]
        lengths = [np.linalg.norm(np.diff(p, axis=0), axis=1).sum() for p in (ours, theirs)]
        assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
        assert (ours[1] - ours[0]) @ (theirs[1] - theirs[0]) > 0.99 * np.sum((theirs[1] - theirs[0]) ** 2)


@pytest.mark.parametrize("direction", [DOWN, (0.0, 1.0, 0.0)])
def test_curves_out_of_a_plane_are_refused(direction):
    with pytest.raises(BadInput, match="strand 0 is bent or upright"):
        droop_rod(laid(direction))
