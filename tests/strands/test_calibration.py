"""The network of Fig. 7b, and that it is the rod it stands for, also where it is curled."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.laws.settings import Construction
from hairpipe.strands import calibration, lattice
from hairpipe.strands import calibration as curl
from hairpipe.strands.calibration import spring_constants
from hairpipe.strands.lattice import area_vectors
from hairpipe.strands.material import Material, fibres_of
from hairpipe.strands.network import SHAPE, constants_by_particle

CONSTANTS = np.array([1.0, 1.0, 1.0, 0.0])


def _straight(segments):
    axis = np.zeros((1, segments + 1, 3))
    axis[0, :, 1] = -np.arange(segments + 1)
    return axis


def _helix(segments):
    s = np.arange(segments + 1) * 0.6
    return np.stack([np.cos(s), np.sin(s), 0.4 * s], axis=1)[None]


def perturbed(axis, turn=lattice.TURN):
    return lattice.perturb(axis, lattice.first_normals(axis, np.eye(3)[None]), turn)


def _floppy_modes(axis, turn=lattice.TURN):
    """Directions of free motion that no spring resists."""
    hessian = calibration.hessian_of(calibration.springs_of(perturbed(axis, turn)[0]), CONSTANTS)
    free = hessian[3 * lattice.CLAMPED :, 3 * lattice.CLAMPED :]
    values = np.linalg.eigvalsh(free)
    return int(np.sum(values < 1e-9 * values.max()))


@pytest.mark.parametrize("axis", [_straight(20), _helix(20)], ids=["straight", "helix"])
def test_triangles_are_equilateral_and_follow_the_axis(axis):
    particles = perturbed(axis)
    assert particles.shape == (1, 2 * 20 + 3, 3)
    np.testing.assert_array_equal(particles[:, SHAPE.axis], axis)
    lengths = lattice.rest_lengths(particles)[0]
    edge = np.linalg.norm(axis[0, 1] - axis[0, 0])
    np.testing.assert_allclose(lengths[:-1, 0], edge, rtol=1e-12)
    np.testing.assert_allclose(lengths[:-2:2, 1], edge, rtol=1e-12)


@pytest.mark.parametrize("axis", [_straight(20), _helix(20)], ids=["straight", "helix"])
def test_springs_are_exactly_as_many_as_degrees_of_freedom(axis):
    free = 3 * (2 * 20 + 3 - lattice.CLAMPED)
    count = 2 * 20 + 3
    springs = sum(max(0, count - o - max(0, lattice.CLAMPED - o)) for o in (1, 2, 3))
    assert springs == free
    assert _floppy_modes(axis) == 0


def test_without_turning_the_network_is_floppy():
    assert _floppy_modes(_straight(20), turn=0.0) >= 2 * 18


def test_the_turn_reverses_its_sense():
    """Perturbed particles of a straight strand turn by 72 degrees a segment, five to the left, five to the right."""
    off_axis = perturbed(_straight(24))[0, 1::2]
    outward = off_axis - off_axis * [0, 1, 0]
    down = np.array([0.0, -1.0, 0.0])
    sines = np.cross(outward[:-1], outward[1:]) @ down / lattice.HEIGHT**2
    cosines = np.sum(outward[:-1] * outward[1:], axis=1) / lattice.HEIGHT**2
    turns = np.rad2deg(np.arctan2(sines, cosines))
    np.testing.assert_allclose(turns, 72 * np.tile(np.repeat([1, -1], lattice.REVERSAL), 3)[: len(turns)], rtol=1e-9)


def test_every_tetrahedron_has_volume():
    for axis in (_straight(10), _helix(10)):
        _, volume = area_vectors(lattice.tetrahedra(perturbed(axis)))
        edge = np.linalg.norm(axis[0, 1] - axis[0, 0])
        assert np.abs(volume).min() > 0.3 * edge**3


def test_volume_gradient_is_a_gradient():
    points = np.random.default_rng(2).normal(size=(1, 4, 3))
    area, _ = area_vectors(lattice.tetrahedra(points))
    for i in np.ndindex(4, 3):
        step = np.zeros_like(points)
        step[0][i] = 1e-6
        ends = (area_vectors(lattice.tetrahedra(points + way))[1] for way in (step, -step))
        slope = np.subtract(*ends) / 2e-6
        np.testing.assert_allclose(area[0, 0][i], slope[0, 0], atol=1e-8)


def test_mass_is_that_of_the_strand():
    mass = lattice.masses(np.array([0.01]), np.full((1, 53), 6.6e-6), 0.05)[0]
    free_length = 25 * 0.01
    buried_half = 0.005 * 0.95
    np.testing.assert_allclose(mass[2:].sum(), 6.6e-6 * (free_length + buried_half), rtol=1e-12)


def test_transport_keeps_length_and_right_angles():
    rng = np.random.default_rng(4)
    start, end = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(2, 50, 3)))
    normals = np.cross(start, rng.normal(size=(50, 3)))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    carried = lattice.transport(normals, start, end)
    np.testing.assert_allclose(np.linalg.norm(carried, axis=1), 1, rtol=1e-12)
    np.testing.assert_allclose(np.sum(carried * end, axis=1), 0, atol=1e-12)


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
