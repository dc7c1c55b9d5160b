"""Rods whose ends are led: the elastica in closed form, and where they have no way on."""

from typing import Any

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.theory.driven_rods import driven_rod, rod_of
from hairpipe.groom.strands import lay_strands

LENGTH, FPS = 0.1, 10.0
BENDING, TORSION = 8e-9, 6e-9
GROOM = lay_strands(1, LENGTH, 40, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.002)


def measured(frames: int, **track) -> dict[str, np.ndarray]:
    tips = Track(**track, ease="linear")
    ends = {n: drive(GROOM, n / FPS, Track(), None, tips, None) for n in range(frames)}
    table = driven_rod(GROOM, ends, FPS, BENDING, TORSION)
    return {name: np.asarray(table[name]) for name in table.names}


def test_pushed_it_is_the_elastica():
    """Clamped at both ends, span / L = 2 E / K - 1 and bulge / L = k / K for some k (Love, 263)."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipk

    found = measured(13, times=(0.0, 1.2), move=((0.0, 0.0, 0.0), (-0.5 * LENGTH, 0.0, 0.0)))
    assert len(found["span [m]"]) == 13
    for span, bulge in zip(found["span [m]"][4:] / LENGTH, found["bulge [m]"][4:] / LENGTH, strict=True):
        m: Any = brentq(lambda m, span=span: 2 * ellipe(m) / ellipk(m) - 1 - span, 1e-6, 0.9)
        assert bulge == pytest.approx(np.sqrt(m) / ellipk(m), rel=2e-3)
    assert abs(found["writhe [1]"]).max() < 1e-6


def test_twisted_it_winds_the_way_it_is_turned():
    slack = ((0.0, 0.0, 0.0), (-0.1 * LENGTH, 0.0, 0.0), (-0.1 * LENGTH, 0.0, 0.0))
    found = [measured(8, times=(0.0, 0.4, 0.7), move=slack, turn=(0, 0, turn), axis=(1, 0, 0)) for turn in (60, -60)]
    for table, sign in zip(found, (1.0, -1.0), strict=True):
        writhe = sign * table["writhe [1]"]
        assert (np.diff(writhe[4:]) > 0.002).all() and np.ptp(writhe[:5]) < 1e-9
        np.testing.assert_allclose(table["turned [rad]"][-1], sign * np.radians(60.0))
    np.testing.assert_allclose(found[0]["bulge [m]"], found[1]["bulge [m]"], rtol=1e-5)
    assert found[0]["bulge [m]"][-1] < found[0]["bulge [m]"][4]


def test_beyond_its_length_there_is_no_equilibrium():
    with pytest.raises(BadInput, match="no equilibrium"):
        measured(1, times=(0.0,), move=((0.04 * LENGTH, 0.0, 0.0),))


def test_a_straight_strand_makes_a_straight_rod():
    straight = lay_strands(1, LENGTH, 10, (0.0, 1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    rod, start = rod_of(straight.points, BENDING, TORSION)
    assert not rod.natural.any() and rod.length == pytest.approx(LENGTH)
    np.testing.assert_allclose(start.frame.T @ start.frame, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(start.frame[:, 2], [0.0, 1.0, 0.0])
