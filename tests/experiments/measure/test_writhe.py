"""Writhe: known values, Gauss' integral by plain summation, and what it may not depend on."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.measure.writhe import writhe


def helix(turns: float, radius: float, pitch: float, count: int) -> np.ndarray:
    """A right-handed helix, (count, 3)."""
    angle = np.linspace(0.0, 2 * np.pi * turns, count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), pitch * angle / (2 * np.pi)])


def gauss(points: np.ndarray) -> float:
    """The double integral over the midpoints of segments."""
    middle, step = (points[1:] + points[:-1]) / 2, np.diff(points, axis=0)
    away = middle[:, None] - middle[None]
    distance = np.linalg.norm(away, axis=2)
    np.fill_diagonal(distance, np.inf)
    volume = np.einsum("ijk,ijk->ij", away, np.cross(step[:, None], step[None]))
    return float(np.sum(volume / distance**3) / (4 * np.pi))


def test_a_long_helix_gives_the_known_value_for_every_turn():
    for radius, pitch in ((1.0, 3.0), (1.0, 8.0)):
        rise = pitch / np.hypot(pitch, 2 * np.pi * radius)
        more = writhe(helix(24, radius, pitch, 961)) - writhe(helix(16, radius, pitch, 641))
        assert more / 8 == pytest.approx(1 - rise, abs=2e-3)


def test_it_is_the_double_integral():
    curve = np.cumsum(np.random.default_rng(3).normal(size=(9, 3)), axis=0)
    smooth = np.column_stack([np.interp(np.linspace(0, 8, 1201), np.arange(9), curve[:, k]) for k in range(3)])
    assert writhe(curve) == pytest.approx(gauss(smooth), abs=3e-3)
    assert writhe(curve) == pytest.approx(writhe(smooth[::40]), abs=1e-2)
    assert abs(writhe(curve)) > 0.1


def test_a_mirror_turns_its_sign_and_nothing_else_changes_it():
    curve = helix(2.3, 0.01, 0.012, 60)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    value = writhe(curve)
    assert value > 0.5
    assert writhe(curve @ turn * 7 + [1, 2, 3]) == pytest.approx(np.sign(np.linalg.det(turn)) * value)
    assert writhe(curve[::-1]) == pytest.approx(value)
    assert writhe(curve * [1, 1, -1]) == pytest.approx(-value)


def test_plane_curves_have_no_writhe():
    angle = np.linspace(0.0, 9.0, 80)
    assert writhe(np.column_stack([angle * np.cos(angle), np.sin(angle), 0 * angle])) == 0.0
    assert writhe(np.zeros((1, 3))) == 0.0
    assert writhe(np.linspace([0, 0, 0], [1, 2, 3], 20)) == 0.0
