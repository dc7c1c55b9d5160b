"""The end of the nine steps of Sec. 4: what is made of the velocity that step 7 has found."""

from types import SimpleNamespace

import numpy as np

from hairpipe.solve.integrators import FullStep, Trapezoid

X, V, HALF = np.random.default_rng(1).normal(size=(3, 4, 3, 8))
MOTION, STEP = SimpleNamespace(x=X, v=V), SimpleNamespace(time=2.0, dt=0.5)


def solved(kind):
    """Find the next velocity with HALF for what a solve finds, and from where and when it was asked for."""
    asked = []

    class Stub(kind):
        def solve(self, motion, step, around, x, h, part, time):
            asked.append((x, h, time))
            return HALF

    return Stub(None).velocity(MOTION, STEP, None, np.zeros_like(X)), asked


def test_the_trapezoid_extrapolates_half_a_step_taken_from_the_middle():
    velocity, [(x, h, time)] = solved(Trapezoid)
    np.testing.assert_array_equal(velocity, 2 * HALF - V)
    np.testing.assert_array_equal(x, X / 2)
    assert (h, time) == (0.25, 2.25)


def test_the_authors_code_takes_a_full_step_at_the_end():
    velocity, [(x, h, time)] = solved(FullStep)
    np.testing.assert_array_equal(velocity, HALF)
    assert x is X and (h, time) == (0.5, 2.5)
