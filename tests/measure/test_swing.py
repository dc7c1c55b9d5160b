"""Lag and swing of hair that turns about the vertical as told."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.measure.motion import swing_table
from hairpipe.values import Strands

OFFSETS = np.arange(0, 45, 9, dtype=np.int32)


def hair_at(led, swung):
    """Four strands that hang around a head somewhere, whose roots and lower quarters have turned by angles [rad]."""
    points = np.empty((36, 3))
    for k in range(36):
        strand, part = divmod(k, 9)
        angle = strand * np.pi / 2 + 0.3 + (swung if part >= 7 else led)
        points[k] = 0.7 + 0.1 * np.sin(angle), -0.03 * part, -0.2 + 0.1 * np.cos(angle)
    return Strands(points, np.zeros((36, 3), np.float32), OFFSETS, 1e-4)


@pytest.mark.parametrize("lag", [0.0, 2.6])
def test_it_is_how_far_hair_turns_and_how_long_after_its_roots(lag):
    at = {1001 + k: k / 24 for k in range(48)}
    hair = {
        frame: hair_at(0.9 * np.sin(8.0 * t), 0.4 * np.sin(8.0 * (t - lag / 24)) if t > lag / 24 else 0.0)
        for frame, t in at.items()
    }
    row = next(swing_table(hair).rows())
    assert row[0] == pytest.approx(lag, abs=0.15) and row[1] > 0.99
    assert row[2:] == pytest.approx(np.degrees((0.8, 1.8)), rel=1e-2)


def test_roots_at_rest_drive_nothing():
    with pytest.raises(BadInput, match="the roots of the hair do not turn"):
        swing_table(dict.fromkeys(range(4), hair_at(0.0, 0.0)))
