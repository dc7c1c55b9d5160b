"""Laws of the altitude spring."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.sim import lattice
from hairpipe.sim.forces.altitude import add_altitude

K = 2.0
REST = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.3, 0.2, 1.1]])


def _inverse_heights(rest):
    return np.repeat(1 / lattice.rest_heights(rest[None])[0, :, :, None], 8, axis=2)


def _apply(system, points, rest=REST):
    s = system(points)
    with np.errstate(divide="ignore"):
        add_altitude(s.A, s.b, s.x, 0, K, _inverse_heights(rest), 1.0)
    return s


def _shortest(points):
    """Index and signed length of the shortest of the seven altitudes, from plane and line distances."""
    heights = []
    for i in range(4):
        a, b, c = (points[j] for j in range(4) if j != i)
        n = np.cross(b - a, c - a)
        heights.append(abs(n @ (points[i] - a)) / np.linalg.norm(n))
    # N_1 + N_2 is the pair of edges (0, 3), (1, 2); N_1 + N_3 is (0, 2), (1, 3); N_2 + N_3 is (0, 1), (2, 3)
    for (i, j), (k, l) in (((0, 3), (1, 2)), ((0, 2), (1, 3)), ((0, 1), (2, 3))):
        n = np.cross(points[j] - points[i], points[l] - points[k])
        heights.append(abs(n @ (points[k] - points[i])) / np.linalg.norm(n))
    volume = np.dot(np.cross(points[2] - points[0], points[3] - points[0]), points[1] - points[0])
    best = int(np.argmin(heights))
    return best, np.sign(volume) * heights[best]


@pytest.mark.parametrize("seed", range(6))
def test_force_is_minus_gradient_of_the_shortest_altitude(system, negative_gradient, seed):
    points = REST + 0.4 * np.random.default_rng(seed).normal(size=(4, 3))
    best, _ = _shortest(points)
    rest = lattice.rest_heights(REST[None])[0, 0, best]

    def energy(x):
        return K / 2 * (_shortest(x)[1] - rest) ** 2 / abs(rest)

    with np.errstate(divide="ignore"):
        force = _apply(system, points).force
    np.testing.assert_allclose(force, negative_gradient(energy, points), rtol=1e-5, atol=1e-6)


def test_rest_shape_and_its_rigid_copies_feel_nothing(system):
    turned = Rotation.from_rotvec([0.3, -1.0, 2.0]).apply(REST) + np.array([1, 2, 3])
    np.testing.assert_allclose(_apply(system, REST).force, 0, atol=1e-14)
    np.testing.assert_allclose(_apply(system, turned).force, 0, atol=1e-13)


def test_momentum_and_angular_momentum_are_kept(system):
    points = REST * [1, 0.3, 1] + 0.1
    force = _apply(system, points).force
    assert np.abs(force).max() > 0.1
    np.testing.assert_allclose(force.sum(0), 0, atol=1e-14)
    np.testing.assert_allclose(np.cross(points, force).sum(0), 0, atol=1e-13)


def test_mirrored_rest_shape_gives_mirrored_force(system):
    mirror = np.array([1.0, 1.0, -1.0])
    points = REST + 0.2 * np.random.default_rng(3).normal(size=(4, 3))
    np.testing.assert_allclose(
        _apply(system, points * mirror, REST * mirror).force, _apply(system, points).force * mirror, atol=1e-13
    )


def test_no_weight_is_negative_in_random_and_flat_tetrahedra(system):
    """Every particle's share of the force lies between 0 and 1, so no force is larger than the spring's own."""
    rng = np.random.default_rng(11)
    for aspect in (1.0, 1e-3, 1e-6):
        for _ in range(200):
            points = rng.normal(size=(4, 3)) * [1, 1, aspect]
            s = _apply(system, points)
            best, height = _shortest(points)
            strain = height / lattice.rest_heights(REST[None])[0, 0, best] - 1
            shares = np.linalg.norm(s.force, axis=1) / (K * abs(strain))
            assert shares.max() <= 1 + 1e-6


def test_inverted_tetrahedron_is_pushed_back(system):
    points = REST.copy()
    points[3, 2] = -0.4
    force = _apply(system, points).force
    assert force[3, 2] > 0


def test_collinear_and_coincident_particles_get_no_force(system):
    line = np.linspace(0, 1, 4)[:, None] * [1.0, 2.0, 3.0]
    for points in (line, np.zeros((4, 3))):
        s = _apply(system, points)
        assert np.all(s.force == 0) and np.all(np.isfinite(s.A))
