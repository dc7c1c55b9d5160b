"""The response of strands to impulses is what these impulses change of a solve."""

import numpy as np
import pytest

from hairpipe.kernels.banded import row_size
from hairpipe.sim.axis import axis_of, gather
from hairpipe.sim.build import integrator_of
from hairpipe.sim.hair_model import build_hair
from hairpipe.sim.material import Material
from hairpipe.sim.settings import Scene
from hairpipe.sim.solve.external_terms import ROWS, ExternalTerms, lay_out
from hairpipe.sim.solve.implicit_stage import factor_stages
from hairpipe.sim.solve.stage import Iterate, Stage, System
from hairpipe.sim.solve.strand_inverse import respond
from hairpipe.studies.contact.bar import tuft

H = 1 / 240


@pytest.mark.parametrize("tips_held", [False, True])
def test_it_is_the_change_of_a_solve(tips_held):
    hair = build_hair(tuft(), Material())
    layout, rule, rng = hair.layout, integrator_of(Scene()).rule, np.random.default_rng(5)
    axis, count, nothing = axis_of(layout), layout.offsets[-1], np.empty((0, 6), np.float32)
    everyone = np.ones(layout.strands.shape)
    weights = H * everyone
    active, held = everyone * (layout.strands % 3 != 0), everyone if tips_held else everyone[:0]
    x, v, T = hair.rest, layout.empty(3), np.zeros_like(hair.model.inverse_lengths)
    v[:] = 0.0
    found = []
    impulses = (1e-8 * rng.normal(size=(count, 3))).astype(np.float32)
    A, none = np.empty_like(layout.empty(row_size(hair.model.shape.reach)), np.float32), np.zeros((count, 3))
    for push in (none, impulses.astype(float)):
        outer, b, change = np.zeros((len(x) // axis.stride, ROWS, layout.width)), layout.empty(3), np.zeros((count, 3))
        terms = ExternalTerms(push / H, np.zeros((count, 6)), none[:0], nothing, nothing)
        lay_out(axis, everyone, terms, none, weights, outer)
        ends = layout.empty_blocks(2 * layout.shape.clamped, 3)
        stage = Stage(x, v, x, v, ends, held, weights, H, H)
        factor_stages(hair.model, System(A, b), Iterate(x, v, T), outer, active, stage, rule)
        gather(axis, everyone, b, change)
        found.append((b, change))
    whole, change = layout.empty(3), np.empty((count, 3), np.float32)
    whole[:] = found[0][0]
    respond(hair.model, axis, System(A, whole), held, active, impulses, change)
    np.testing.assert_allclose(change, found[1][1] - found[0][1], atol=1e-6 * np.abs(change).max())
    np.testing.assert_allclose(whole, found[1][0], atol=1e-6 * np.abs(whole).max())
    assert np.abs(change).max() > 1e-4
    strands = np.repeat(np.arange(len(layout.offsets) - 1), np.diff(layout.offsets))
    assert not change[strands % 3 == 0].any()
    if tips_held:
        assert not change[layout.offsets[1:] - 1].any()
