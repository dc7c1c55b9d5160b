"""Where a stage begins that something takes part in, and what the nine steps make of a velocity."""

from types import SimpleNamespace

import numpy as np
import pytest

from hairpipe.graphs.experiments.bench.strands import RULE, STEP, hang
from hairpipe.solve.implicit_stage import guess_stages
from hairpipe.solve.integrator import everywhere
from hairpipe.solve.integrators import BackwardEuler, FullStep, Trapezoid
from hairpipe.solve.stage import Iterate, Stage, State, Step

H, SPAN = 0.3 * STEP, 0.6 * STEP
"""Weight of the stage's end, and the time that it covers [s]: unlike, as in TR-BDF2."""


class Case:
    """Strands in a stage, of which every second one is torn at its tip."""

    def __init__(self):
        self.hair = hang(16, 6, np.float64)
        self.v = np.random.default_rng(1).normal(scale=1e-3, size=self.hair.rest.shape)
        self.v.reshape(self.hair.weights.shape[0], -1, 3, self.hair.rest.shape[2])[:, -4:, 0, ::2] += 30.0
        self.torn = np.zeros(self.hair.rest.shape[2], bool)
        self.torn[::2] = True

    def guess(self):
        hair, x0 = self.hair, self.hair.rest
        step = Step(hair.path, 0.0, SPAN)
        xh, x, v, T = x0 + 1e-6, x0.copy(), self.v.copy(), hair.motion.T.copy()
        weights = everywhere(hair.model, x0, H)
        stage = Stage(xh, v, x0, v, step.ends(1.0), step.held, weights, SPAN, SPAN)
        guess_stages(hair.model, Iterate(x, v, T), stage, RULE)
        return xh, x, v, T

    def alone(self):
        """Go by backward Euler over the span of the stage."""
        hair, x0 = self.hair, self.hair.rest
        motion = State(x0.copy(), self.v.copy(), np.zeros_like(x0), hair.motion.T.copy(), hair.motion.fresh)
        BackwardEuler(RULE._replace(guard=np.inf)).advance(hair.model, motion, Step(hair.path, 0.0, SPAN), hair.around)
        return motion


@pytest.fixture(scope="module")
def case():
    return Case()


def test_a_strand_that_the_guess_tears_goes_by_backward_euler(case):
    xh, x, _, T = case.guess()
    alone = case.alone()
    np.testing.assert_allclose(x[..., case.torn], alone.x[..., case.torn], rtol=0, atol=1e-12)
    np.testing.assert_allclose(T[..., case.torn], alone.T[..., case.torn], rtol=1e-9, atol=1e-12)
    assert np.abs(alone.x - (xh + H * case.v))[..., case.torn].max() > 1e-3


def test_the_others_are_where_their_guess_leads(case):
    xh, x, v, T = case.guess()
    free = slice(3, 6)  # the first that no root holds
    np.testing.assert_allclose(x[free][..., ~case.torn], (xh + H * case.v)[free][..., ~case.torn], rtol=0, atol=1e-15)
    assert np.array_equal(v[free][..., ~case.torn], case.v[free][..., ~case.torn])
    assert np.array_equal(T[..., ~case.torn], case.hair.motion.T[..., ~case.torn])


def test_all_are_in_the_stage(case):
    xh, x, v, _ = case.guess()
    np.testing.assert_allclose(x, xh + H * v, rtol=0, atol=1e-15)


X, V, HALF = np.random.default_rng(1).normal(size=(3, 4, 3, 8))
MOTION, HALFWAY = SimpleNamespace(x=X, v=V), SimpleNamespace(time=2.0, dt=0.5)


def solved(kind):
    """Find the next velocity with HALF for what a solve finds, and from where and when it was asked for."""
    asked = []

    class Stub(kind):
        def solve(self, motion, step, around, x, h, part, time):
            asked.append((x, h, time))
            return HALF

    return Stub(None).velocity(MOTION, HALFWAY, None, np.zeros_like(X)), asked


def test_the_trapezoid_extrapolates_half_a_step_taken_from_the_middle():
    velocity, [(x, h, time)] = solved(Trapezoid)
    np.testing.assert_array_equal(velocity, 2 * HALF - V)
    np.testing.assert_array_equal(x, X / 2)
    assert (h, time) == (0.25, 2.25)


def test_the_authors_code_takes_a_full_step_at_the_end():
    velocity, [(x, h, time)] = solved(FullStep)
    np.testing.assert_array_equal(velocity, HALF)
    assert x is X and (h, time) == (0.5, 2.5)
