"""Lanes compute what eight separate numbers would."""

import numpy as np
from numba import njit

from hairpipe.sim.lanes import WIDTH, any_lane, either, load, maximum, minimum, select, sqrt, store


@njit
def _everything(a, b, out):
    x, y = load(a, (0,)), load(b, (0,))
    store(out, (0,), x + 2 * y)
    store(out, (1,), 1.0 - x)
    store(out, (2,), x * y / 3.0)
    store(out, (3,), sqrt(maximum(x, 0.0)))
    store(out, (4,), minimum(x, y))
    store(out, (5,), select(either(x < y, x > 0.5), -x, y))


@njit
def _any_above(a, limit):
    return any_lane(load(a, (0,)) > limit)


def test_operators_agree_with_numpy():
    a, b = np.random.default_rng(1).normal(size=(2, 1, WIDTH))
    out = np.empty((6, WIDTH))
    _everything(a, b, out)
    x, y = a[0], b[0]
    expected = [
        x + 2 * y,
        1 - x,
        x * y / 3,
        np.sqrt(np.maximum(x, 0)),
        np.minimum(x, y),
        np.where((x < y) | (x > 0.5), -x, y),
    ]
    np.testing.assert_allclose(out, expected, rtol=1e-15, atol=1e-15)


def test_any_lane_sees_every_lane():
    for lane in range(WIDTH):
        a = np.zeros((1, WIDTH))
        a[0, lane] = 1.0
        assert _any_above(a, 0.5)
    assert not _any_above(np.zeros((1, WIDTH)), 0.5)
