"""The plain chain: half the particles, and the same straight hair."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.strands import network
from hairpipe.strands.chain import SHAPE, STRAIGHTEST
from hairpipe.strands.material import Material

G = 9.81


def test_it_swings_like_the_network(scene, straight):
    """The tip of 10 cm, let go 57 degrees off the vertical, over half a second: a swing and a half."""
    strand = straight(0.1, 20, [np.sin(1.0), -np.cos(1.0), 0])
    chain, full = (scene([strand], model=model) for model in ("chain", "network"))
    tips = np.array([[s.run(1 / 24).axis[-1] for s in (chain, full)] for _ in range(12)])
    np.testing.assert_allclose(tips[:, 0], tips[:, 1], atol=0.03 * 0.1)
    assert np.linalg.norm(tips - strand[-1], axis=2).max() > 0.5 * 0.1, "it does swing"


def test_a_strand_has_half_the_particles_and_all_of_the_mass(scene, straight):
    """Free are 20 segments; m_0 carries half a segment of what is buried, too."""
    chain = scene([straight(0.1, 20, [0, -1, 0])], model="chain")
    assert chain.state.positions.shape[0] == SHAPE.count(20) == 22
    assert network.SHAPE.count(20) == 43
    mass = chain.hair.model.mass[SHAPE.clamped - 1 :, 0].sum()
    np.testing.assert_allclose(mass, Material().line_density * 0.1 * 20.5 / 20, rtol=1e-12)


def test_curls_are_refused(scene):
    around = np.arange(26) * 0.7
    curl = np.stack([0.01 * np.cos(around), -0.004 * np.arange(26.0), 0.01 * np.sin(around)], axis=1)
    with pytest.raises(BadInput, match="straight at rest") as refused:
        scene([curl], model="chain")
    assert refused.value.where == "model" and "network" in str(refused.value.right)


def test_nearly_straight_strands_are_accepted(scene):
    angles = np.cumsum(np.r_[0.0, np.tile([1.0, -1.0], 5)]) * 0.9 * STRAIGHTEST
    steps = 0.005 * np.stack([np.sin(angles), -np.cos(angles), np.zeros(11)], axis=1)
    zigzag = np.concatenate([[[0.0, 0.0, 0.0]], np.cumsum(steps, axis=0)])
    scene([zigzag], model="chain").run(1 / 24)
