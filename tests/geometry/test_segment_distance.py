"""The closest points of two segments."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.segment_distance import closest_of, closest_on_segments

from ..segment_scenes import distances_of


@njit
def _all(points, out):
    for k in range(len(out)):
        out[k] = closest_of(points, 4 * k, 4 * k + 2)


def of(*points):
    return closest_on_segments(*(tuple(map(float, p)) for p in points))


def test_no_other_places_are_closer():
    """Nearly parallel, coplanar, touching and short ones, beside independent formulas; a hundred thousand of them."""
    rng = np.random.default_rng(1)
    points = rng.normal(size=(100_000, 4, 3))
    points[::4] = np.round(2 * points[::4]) / 2
    angles = 10.0 ** rng.uniform(-16, -1, (25_000, 1))
    points[1::4, 3] = points[1::4, 2] + rng.normal(size=(25_000, 1)) * (points[1::4, 1] - points[1::4, 0])
    points[1::4, 3] += angles * rng.normal(size=(25_000, 3))
    points[2::4, 1] = points[2::4, 0] + angles * rng.normal(size=(25_000, 3))
    flat = points.reshape(-1, 3)
    found = np.empty((len(points), 3))
    _all(flat, found)
    first = 4 * np.arange(len(points))
    expected = distances_of(flat, first, first + 2)
    np.testing.assert_allclose(np.sqrt(found[:, 2]), expected, atol=2e-14)
    assert ((found[:, :2] >= 0) & (found[:, :2] <= 1)).all()


def test_parallel_ones_are_closest_in_the_middle_of_their_overlap():
    u = np.array([0.1, 0.7, -0.3])
    n = np.array([0.7, -0.1, 0.0])
    s, t, squared = of(0 * u, u, 0.5 * u + n, 2 * u + n)
    assert (s, t, squared) == pytest.approx((0.75, 1 / 6, n @ n))
    assert of(0 * u, u, 2 * u + n, 0.5 * u + n)[:2] == pytest.approx((0.75, 5 / 6))
    assert of(0 * u, u, 3 * u, 2 * u) == pytest.approx((1, 1, u @ u))


def test_coincident_and_without_length():
    a, b = np.array([0.2, 0.3, 0.1]), np.array([1.0, 0.0, 0.4])
    assert of(a, b, a, b) == pytest.approx((0.5, 0.5, 0.0))
    assert of(a, a, a, a)[2] == 0.0
    assert of(a, a, b, b)[2] == pytest.approx((a - b) @ (a - b))
    assert of((0, 1, 0), (0, 1, 0), (-1, 0, 0), (3, 0, 0))[1:] == pytest.approx((0.25, 1.0))
    assert of((-1, 0, 0), (3, 0, 0), (0, 1, 0), (0, 1, 0))[::2] == pytest.approx((0.25, 1.0))
