"""Laws of biased strain limiting."""

import numpy as np

from hairpipe.laws.strain_limit import limit_strain
from hairpipe.strands.network import SHAPE

CLAMPED = SHAPE.clamped


def _stretched(scene, straight, rng):
    """A strand with every free particle thrown about, and one that is left alone."""
    s = scene([straight(0.1, 12, [0, -1, 0]), straight(0.1, 12, [0, -1, 0])])
    x = s.state.positions
    x[CLAMPED:, :, 0] += rng.normal(scale=0.004, size=x[CLAMPED:, :, 0].shape)
    return s.hair.model, x


def test_no_segment_is_longer_than_the_limit_after_one_pass(scene, straight):
    network, x = _stretched(scene, straight, np.random.default_rng(1))
    limit_strain(x, network.inverse_lengths, SHAPE, 1.02)
    lengths = np.linalg.norm(x[2::2, :, 0] - x[:-2:2, :, 0], axis=1) * network.inverse_lengths[:-2:2, 1, 0]
    assert lengths[1:].max() <= 1.02 * (1 + 1e-12)
    off_axis = np.linalg.norm(x[3::2, :, 0] - x[2:-1:2, :, 0], axis=1) * network.inverse_lengths[2:-1:2, 0, 0]
    assert off_axis.max() <= 1.02 * (1 + 1e-12)


def test_strain_within_the_limit_is_unchanged(scene, straight):
    network, x = _stretched(scene, straight, np.random.default_rng(2))
    before = x.copy()
    limit_strain(x, network.inverse_lengths, SHAPE, 1e3)  # to the bit, in any direction
    np.testing.assert_array_equal(x, before)
    limit_strain(x, network.inverse_lengths, SHAPE, 1.02)
    np.testing.assert_array_equal(x[:, :, 1], before[:, :, 1])
    np.testing.assert_array_equal(x[:CLAMPED], before[:CLAMPED])


def test_a_second_pass_changes_nothing(scene, straight):
    network, x = _stretched(scene, straight, np.random.default_rng(3))
    limit_strain(x, network.inverse_lengths, SHAPE, 1.02)
    once = x.copy()
    limit_strain(x, network.inverse_lengths, SHAPE, 1.02)
    np.testing.assert_allclose(x, once, atol=1e-15)


def test_only_the_far_particle_moves_along_the_segment(scene, straight):
    network, x = _stretched(scene, straight, np.random.default_rng(4))
    x[:] = scene([straight(0.1, 12, [0, -1, 0])] * 2).state.positions
    x[-1, :, 0] += [0.01, -0.02, 0.0]
    before = x.copy()
    limit_strain(x, network.inverse_lengths, SHAPE, 1.0)
    assert np.all(x[:-1] == before[:-1])
    old, new = before[-1, :, 0] - x[-3, :, 0], x[-1, :, 0] - x[-3, :, 0]
    np.testing.assert_allclose(np.cross(old, new), 0, atol=1e-12)
