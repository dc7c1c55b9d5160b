"""The cubic spline is what the paper says of it."""

import numpy as np
import pytest

from hairpipe.particles.model import kernel, shape, slope


def test_its_integral_is_1_and_its_value_at_0_that_of_the_paper():
    h, r = 0.03, np.linspace(0.0, 0.07, 20_001)
    assert np.sum(4.0 * np.pi * r**2 * kernel(r, h)) * r[1] == pytest.approx(1.0, rel=1e-6)
    assert kernel(np.zeros(1), h)[0] == pytest.approx(1.0 / (np.pi * h**3))
    assert not kernel(np.array([2.0 * h, 5.0 * h]), h).any()


def test_shape_and_slope_equal_the_kernel_and_its_derivative():
    q, step = np.linspace(0.05, 2.5, 50), 1e-5
    assert [shape.py_func(x) for x in q] == pytest.approx(4.0 * np.pi * kernel(q, 1.0), abs=1e-12)
    differences = [(shape.py_func(x + step) - shape.py_func(x - step)) / (2.0 * step) for x in q]
    assert [slope.py_func(x) for x in q] == pytest.approx(differences, abs=1e-5)
