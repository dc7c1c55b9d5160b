"""The calibrated network is the rod it stands for, also where it is curled."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.laws.settings import Construction
from hairpipe.strands import calibration, lattice
from hairpipe.strands import calibration as curl
from hairpipe.strands.calibration import spring_constants
from hairpipe.strands.material import Material, fibres_of
from hairpipe.strands.network import constants_by_particle

DEFAULT = Construction()


def test_stiffness_agrees_with_the_closed_form_at_right_angles(monkeypatch):
    """Compliances of springs in series: 1/EI = (2/k_e + 4 sqrt3/k_t)/l^2 and so on."""
    monkeypatch.setattr(lattice, "REVERSAL", 1_000)  # the closed form is that of a turn that keeps its sense
    edge, bending, torsion = 50.0, 7.0, 5.0
    bend = 1 / (2 / edge + 4 * np.sqrt(3) / torsion)
    twist = 1 / (44 / 9 / edge + 16 / 9 * 2.5**1.5 / bending + 8 / np.sqrt(3) / torsion)
    stiffness = calibration.rod_stiffness(np.array([edge, bending, torsion, 0.0]), calibration.straight_rod(np.pi / 2))
    np.testing.assert_allclose(stiffness, [bend, twist], rtol=1e-9)


@pytest.mark.parametrize("poisson", [0.0, 0.35, 0.5])
def test_network_has_the_stiffness_of_the_material_at_every_length(poisson):
    material = Material(poisson=poisson)
    lengths = np.array([0.0008, 0.002, 0.005, 0.02])
    for length, constants in zip(lengths, calibration.spring_constants(material, DEFAULT, lengths).T, strict=True):
        stiffness = calibration.rod_stiffness(constants, calibration.straight_rod(lattice.TURN)) * length**2
        np.testing.assert_allclose(stiffness, [material.bending, material.torsion], rtol=1e-3)


def test_constants_do_not_depend_on_the_other_strands():
    alone = calibration.spring_constants(Material(), DEFAULT, np.array([0.004]))
    among = calibration.spring_constants(Material(), DEFAULT, np.array([0.001, 0.004, 0.02]))
    np.testing.assert_array_equal(alone[:, 0], among[:, 1])


def test_short_segments_are_softened_as_far_as_they_may_be_and_others_do_not_feel_it():
    """The network of each still has the stiffness of the rod."""
    lengths, material = np.array([0.00057, 0.004, 0.0001]), Material()
    assert calibration.softenings(material, lengths) == pytest.approx([81.225, 100.0, 2.5])
    constants = calibration.spring_constants(material, DEFAULT, lengths)
    np.testing.assert_array_equal(constants[:, 1], calibration.spring_constants(material, DEFAULT, lengths[1:2])[:, 0])
    for length, own in zip(lengths, constants.T, strict=True):
        stiffness = calibration.rod_stiffness(own, calibration.straight_rod(lattice.TURN)) * length**2
        np.testing.assert_allclose(stiffness, [material.bending, material.torsion], rtol=2e-3)


def test_omitted_springs_do_not_stiffen_others():
    """Factors scale what the full network has; altitude springs are left out of the fit, so that EI and GJ stay."""
    length = np.array([0.004])
    edge, bending, torsion, altitude = calibration.spring_constants(Material(), DEFAULT, length)
    part = calibration.spring_constants(Material(), Construction(bending=0.0, torsion=0.5), length)
    np.testing.assert_allclose(part, [edge, 0 * bending, 0.5 * torsion, 0.5 * altitude])
    bare = calibration.spring_constants(Material(), Construction(altitude=0.0), length)
    assert bare[3] == 0
    stiffness = calibration.rod_stiffness(bare[:, 0], calibration.straight_rod(lattice.TURN)) * length**2
    np.testing.assert_allclose(stiffness, [Material().bending, Material().torsion], rtol=1e-3)


@pytest.mark.parametrize("turn", [60.0, 90.0, 110.0])
def test_constants_are_those_of_the_turn(turn):
    length, material = np.array([0.004]), Material()
    constants = calibration.spring_constants(material, Construction(turn=turn), length)[:, 0]
    stiffness = calibration.rod_stiffness(constants, calibration.straight_rod(np.deg2rad(turn))) * length**2
    np.testing.assert_allclose(stiffness, [material.bending, material.torsion], rtol=1e-3)


def test_a_turn_that_no_constants_fit_is_refused():
    with pytest.raises(BadInput, match="at a turn of 45 deg"):
        calibration.spring_constants(Material(), Construction(turn=45.0), np.array([0.004]))


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
