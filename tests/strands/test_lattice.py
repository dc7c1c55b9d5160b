"""The network of Fig. 7b: counts, rank, volumes, and what turning the perturbed particles is for."""

import numpy as np
import pytest

from hairpipe.strands import calibration, lattice
from hairpipe.strands.lattice import area_vectors
from hairpipe.strands.network import SHAPE

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
