"""Curls: what the tip of a network and that of a rod resist, and which strands are fitted."""

import numpy as np
import pytest

from hairpipe.geometry.curl import Helix, wound
from hairpipe.laws.settings import Construction
from hairpipe.strands import calibration as curl
from hairpipe.strands import lattice
from hairpipe.strands.calibration import spring_constants
from hairpipe.strands.material import Material, fibres_of
from hairpipe.strands.network import constants_by_particle


def fitted(axis):
    """Give the fit of strands, and the compliances of their rods and of their networks at the tip."""
    frames = np.broadcast_to(np.eye(3), (len(axis), 3, 3))
    length = np.linalg.norm(np.diff(axis, axis=1), axis=2).mean(1)
    edges, *joints = spring_constants(Material(), Construction(), length[:, None])
    edges, joints = np.repeat(edges, axis.shape[1] - 1, axis=1), np.repeat(joints, axis.shape[1], axis=2)
    section = fibres_of(None, Material()).of(np.zeros(axis.shape[:2], int)).points
    constants = constants_by_particle(edges, joints)
    fit = curl.fit_curls(axis, lattice.first_normals(axis, frames), lattice.TURN, constants, section)
    constants = constants_by_particle(edges, joints * fit.factors[:, None])
    rod = curl.tip_of_rod(axis, edges, section)
    network = curl.tip_of_network(lattice.perturb(axis, fit.normals, fit.turns), constants)
    return fit, rod @ rod.transpose(0, 2, 1), np.linalg.inv(network)


def test_the_tip_of_a_straight_rod_gives_way_as_the_beam_does():
    length, material = 0.1, Material()
    axis = np.linspace(0.0, length, 201)[None, :, None] * np.array([0.0, 0.0, 1.0])
    half = curl.tip_of_rod(axis, np.array([material.axial]), material)[0]
    beam = length**3 / (3.0 * material.bending)
    np.testing.assert_allclose(
        half @ half.T, np.diag([beam, beam, length / material.axial]), rtol=1e-4, atol=1e-9 * beam
    )


@pytest.mark.parametrize(
    ("radius", "pitch", "length", "segments"),
    [(0.015, 0.03, 0.3, 25), (0.004, 0.008, 0.133, 50), (0.02, 0.01, 0.3, 25)],
)
def test_the_tip_of_a_curl_gives_way_as_that_of_the_rod_in_all_directions(radius, pitch, length, segments):
    """Either hand; within 20 % in any direction, on the mean as it."""
    right = wound(Helix(radius, pitch), length, segments)
    _, rods, networks = fitted(np.stack([right, right * [1, -1, 1]]))
    ratios = [np.linalg.eigvals(np.linalg.solve(*both)).real for both in zip(rods, networks, strict=True)]
    assert np.min(ratios) > 0.8 and np.max(ratios) < 1.2
    np.testing.assert_allclose(np.mean(ratios, axis=1), 1.0, atol=0.02)
    np.testing.assert_allclose(np.sort(ratios[0]), np.sort(ratios[1]), rtol=1e-7)


def test_straight_strands_are_left_alone_and_strands_do_not_matter_to_each_other():
    straight = np.linspace(0.0, 0.1, 21)[:, None] * [0.0, 1.0, 0.0]
    curled = wound(Helix(0.01, 0.02), 0.1, 20)
    both, alone = fitted(np.stack([straight, curled]))[0], fitted(curled[None])[0]
    assert both.factors[0] == 1.0 and both.turns[0] == lattice.TURN
    np.testing.assert_array_equal([both.factors[1], both.turns[1, 0]], [alone.factors[0], alone.turns[0, 0]])
