"""Where a stage begins, what the nine steps make of a velocity, and the response of strands to impulses."""

from types import SimpleNamespace

import numpy as np
import pytest

from hairpipe.graphs.experiments.bench.strands import RULE, STEP, hang
from hairpipe.graphs.experiments.studies.contact.bar import tuft
from hairpipe.laws.settings import Scheme
from hairpipe.shot.build import integrator_of
from hairpipe.shot.settings import Scene
from hairpipe.solve.band import row_size
from hairpipe.solve.boundary import ClampPath, clamp_at
from hairpipe.solve.implicit_stage import ROWS, ExternalTerms, factor_stages, guess_stages, lay_out
from hairpipe.solve.integrator import everywhere
from hairpipe.solve.integrators import BackwardEuler, FullStep, Trapezoid
from hairpipe.solve.interactions import Interaction
from hairpipe.solve.stage import Iterate, Stage, State, Step, System
from hairpipe.solve.stretch import LENGTH_JUMP, StrainFilter, mark_length_jumps
from hairpipe.solve.surroundings import Surroundings, respond
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.layout import axis_of
from hairpipe.strands.material import Material

WEIGHT, SPAN = 0.3 * STEP, 0.6 * STEP
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
        weights = everywhere(hair.model, x0, WEIGHT)
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
    assert np.abs(alone.x - (xh + WEIGHT * case.v))[..., case.torn].max() > 1e-3


def test_the_others_are_where_their_guess_leads(case):
    xh, x, v, T = case.guess()
    free = slice(3, 6)  # the first that no root holds
    np.testing.assert_allclose(
        x[free][..., ~case.torn], (xh + WEIGHT * case.v)[free][..., ~case.torn], rtol=0, atol=1e-15
    )
    assert np.array_equal(v[free][..., ~case.torn], case.v[free][..., ~case.torn])
    assert np.array_equal(T[..., ~case.torn], case.hair.motion.T[..., ~case.torn])


def test_all_are_in_the_stage(case):
    xh, x, v, _ = case.guess()
    np.testing.assert_allclose(x, xh + WEIGHT * v, rtol=0, atol=1e-15)


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


H = 1 / 240


def solve(hair, x, push, A, active, held):
    """Solve for forces on points [N], with factors left in A; return the change of particles and of points [m/s]."""
    layout, rule, (rows, _, width) = hair.layout, integrator_of(Scene()).rule, x.shape
    axis, count, nothing = axis_of(layout), layout.offsets[-1], np.empty((0, 6), np.float32)
    everyone = np.ones(layout.strands.shape)
    v, T, b = np.zeros_like(x), np.zeros_like(hair.model.inverse_lengths), layout.empty(hair.model.shape.unknowns)
    outer, change = np.zeros((rows // axis.stride, ROWS, width)), np.zeros((count, 3))
    terms = ExternalTerms(push, np.zeros((count, 6)), push[:0], nothing, nothing)
    lay_out(axis, everyone, terms, np.zeros((count, 3)), H * everyone, outer)
    ends = layout.empty_blocks(2 * layout.shape.clamped, 3)
    stage = Stage(x, v, x, v, ends, held, H * everyone, H, H)
    factor_stages(hair.model, System(A, b), Iterate(x, v, T), outer, active, stage, rule)
    axis.gather(b, change, active=everyone)
    return b, change


@pytest.mark.parametrize("tips_held", [False, True])
def test_it_is_the_change_of_a_solve(tips_held):
    hair = build_hair(tuft(), Material(), "network")
    layout, rng = hair.layout, np.random.default_rng(5)
    everyone, count = np.ones(layout.strands.shape), layout.offsets[-1]
    active, held = everyone * (layout.strands % 3 != 0), everyone if tips_held else everyone[:0]
    impulses = (1e-8 * rng.normal(size=(count, 3))).astype(np.float32)
    A = np.empty_like(layout.empty(row_size(hair.model.shape)), np.float32)
    found = [
        solve(hair, hair.rest, push / H, A, active, held) for push in (np.zeros((count, 3)), impulses.astype(float))
    ]
    whole, change = found[0][0].copy(), np.empty((count, 3), np.float32)
    respond(hair.model, axis_of(layout), System(A, whole), held, active, impulses, change)
    np.testing.assert_allclose(change, found[1][1] - found[0][1], atol=1e-6 * np.abs(change).max())
    np.testing.assert_allclose(whole, found[1][0], atol=1e-6 * np.abs(whole).max())
    assert np.abs(change).max() > 1e-4
    strands = np.repeat(np.arange(len(layout.offsets) - 1), np.diff(layout.offsets))
    assert not change[strands % 3 == 0].any()
    if tips_held:
        assert not change[layout.offsets[1:] - 1].any()


def test_rods_of_indefinite_stiffness_respond_as_if_it_were_positive():
    """One that does not would break conjugate gradients for all that touch; the others are solved as they were."""
    hair = build_hair(tuft(), Material(), "rod")
    layout, rng = hair.layout, np.random.default_rng(6)
    axis, count, everyone = axis_of(layout), layout.offsets[-1], np.ones(layout.strands.shape)
    x, still, factors = layout.empty(3), np.zeros((count, 3)), []
    for crushed in (0.0, 3e-3):
        x[:] = hair.rest
        x[3:, :, 0] += crushed * rng.normal(size=x[3:, :, 0].shape)
        factors.append(np.empty_like(layout.empty(row_size(hair.model.shape)), np.float32))
        solve(hair, x, still, factors[-1], everyone, everyone[:0])
    np.testing.assert_array_equal(factors[0][..., 1:], factors[1][..., 1:])
    strand = layout.strands[0, 0]
    points = 3 * np.arange(layout.offsets[strand] + 1, layout.offsets[strand + 1])[:, None] + np.arange(3)
    response = np.empty((points.size, points.size))
    for column, point in enumerate(points.ravel()):
        impulses, change = np.zeros((count, 3), np.float32), np.empty((count, 3), np.float32)
        impulses.ravel()[point] = 1e-8
        nowhere = System(factors[1], layout.empty(4)[:0])
        respond(hair.model, axis, nowhere, everyone[:0], everyone, impulses, change)
        response[:, column] = change.ravel()[points.ravel()]
    assert np.linalg.eigvalsh(response + response.T).min() > 0.0


FRAME = 1 / 24


def _two(scene, straight, **how):
    return scene([straight(0.1, 12, [0, -1, 0]), straight(0.1, 12, [1, -1, 0])], **how)


def _pull(shot, x, lane, part):
    """Draw the last point of a strand out along its segment by a part of that."""
    axis = shot.hair.layout.axis(x).reshape(2, -1, 3)[lane]
    x[-1, :, lane] += part * (axis[-1] - axis[-2])


@pytest.mark.parametrize("model", ["network", "chain"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_strands_of_which_a_segment_changed_its_length_are_marked(scene, straight, model, sign):
    shot = _two(scene, straight, model=model)
    before, after = shot.state.positions, shot.state.positions.copy()
    _pull(shot, after, 0, 0.9 * sign * LENGTH_JUMP)
    _pull(shot, after, 1, 1.1 * sign * LENGTH_JUMP)
    marks = np.zeros(shot.hair.layout.strands.shape, shot.hair.layout.dtype)
    mark_length_jumps(shot.hair.model, before, after, marks)
    np.testing.assert_array_equal(marks[0, :2], [0.0, 1.0])


def test_rotation_about_the_root_is_not_an_acceleration(scene, straight):
    shot = _two(scene, straight)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    before = shot.state.positions
    marks = np.zeros(shot.hair.layout.strands.shape, shot.hair.layout.dtype)
    mark_length_jumps(shot.hair.model, before, np.einsum("ij,pjw->piw", turn, before), marks)
    assert not marks.any()


@pytest.mark.parametrize("value", ["tr_bdf2", "bdf2"])
def test_stretched_strands_restart(scene, straight, value):
    """And the other strand goes on with its own."""
    shot = _two(scene, straight, scheme=Scheme(value=value))

    class Pulling(Interaction):
        in_solve = False

        def correct(self, end):
            _pull(shot, end.x, 1, 0.01)

    state, hair = shot.state, shot.hair
    motion = State.begin(state, state.positions)
    around = Surroundings(hair.model, hair.layout, [StrainFilter(hair.model, 0.1), Pulling()])
    held = clamp_at(shot.body, hair.groom, hair.rest, hair.layout)
    integrator = integrator_of(shot.scene)
    for time in (0.0, FRAME / 8):
        integrator.advance(hair.model, motion, Step(ClampPath(held, held, FRAME), time, FRAME / 8), around)
        assert motion.fresh[0, :2].tolist() == [False, True]
    assert np.isfinite(motion.x).all() and np.abs(motion.v).max() < 10.0
