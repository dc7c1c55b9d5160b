"""The response of strands to impulses is what these impulses change of a solve."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.contact.bar import tuft
from hairpipe.shot.build import integrator_of
from hairpipe.shot.settings import Scene
from hairpipe.solve.band import row_size
from hairpipe.solve.implicit_stage import ROWS, ExternalTerms, factor_stages, lay_out
from hairpipe.solve.stage import Iterate, Stage, System
from hairpipe.solve.surroundings import respond
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.layout import axis_of
from hairpipe.strands.material import Material

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
