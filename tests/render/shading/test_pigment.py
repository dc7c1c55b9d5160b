"""Pigment makes the colours that hair has, and Blender finds the pigment again."""

import numpy as np
import pytest

from hairpipe.render.shading.pigment import pigment_colour


def test_pigment_darkens_from_white_to_black_blue_first() -> None:
    shades = np.array([pigment_colour(melanin, 0.5) for melanin in (0.0, 0.3, 0.6, 0.9, 1.0)])
    assert (
        np.array_equal(shades[0], [1.0, 1.0, 1.0]) and np.all(np.diff(shades, axis=0) < 0) and shades[-1].max() < 1e-3
    )
    assert np.all(np.diff(shades[1:], axis=1) < 0)
    red, brown = pigment_colour(0.5, 1.0), pigment_colour(0.5, 0.0)
    assert red[0] / red[2] > brown[0] / brown[2]


def test_absorption_is_that_which_blender_finds_for_the_colour() -> None:
    """Chiang et al. 2016: sigma = (ln C / f)^2, f = 5.969 - 0.215 b + 2.532 b^2 - 10.73 b^3 + 5.574 b^4 + 0.245 b^5."""
    b = 0.3
    f = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    sigma = (np.log(pigment_colour(0.6, 0.0)) / f) ** 2
    assert sigma == pytest.approx(-np.log(0.4) * np.array([0.506, 0.841, 1.653]), rel=1e-9)
