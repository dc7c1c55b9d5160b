"""Laws of the altitude spring."""

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

from hairpipe.geometry.simd import load
from hairpipe.laws.altitude import linearise_altitude
from hairpipe.strands.assembly import add_tetrahedron

K = 2.0
REST = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.3, 0.2, 1.1]])


@njit
def _add(A, b, x, inverse_heights):
    zero = 0.0 * load(x, (0, 0))
    spring = (zero, zero, zero), (zero, zero, zero, zero, zero, zero)
    add_tetrahedron(A, b, 0, linearise_altitude(x, 0, K, inverse_heights, 1.0, 1.0), spring, spring, spring)


def _apply(system, points, rest=REST):
    s = system(points)
    heights = _heights(rest)
    inverse = np.divide(1, heights, out=np.zeros(7), where=heights != 0)
    _add(s.A, s.b, s.x, np.repeat(inverse[None, :, None], 8, axis=2))
    return s


def _heights(points):
    """Signed lengths of the seven altitudes, from plane and line distances."""
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
    return np.sign(volume) * np.array(heights)


def _shortest(points):
    """Index and signed length of the shortest altitude."""
    heights = _heights(points)
    best = int(np.argmin(np.abs(heights)))
    return best, heights[best]


@pytest.mark.parametrize("seed", range(6))
def test_force_is_minus_gradient_of_the_shortest_altitude(system, negative_gradient, seed):
    points = REST + 0.4 * np.random.default_rng(seed).normal(size=(4, 3))
    best, _ = _shortest(points)
    rest = _heights(REST)[best]

    def energy(x):
        return K / 2 * (_shortest(x)[1] - rest) ** 2 / abs(rest)

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


def test_inverted_tetrahedron_is_pushed_back(system):
    points = REST.copy()
    points[3, 2] = -0.4
    force = _apply(system, points).force
    assert force[3, 2] > 0


def test_force_is_no_larger_than_the_spring_s_own(system):
    rng = np.random.default_rng(11)
    for aspect in (1.0, 1e-3, 1e-6):
        for _ in range(20):
            points = rng.normal(size=(4, 3)) * [1, 1, aspect]
            best, height = _shortest(points)
            strain = height / _heights(REST)[best] - 1
            force = np.linalg.norm(_apply(system, points).force, axis=1)
            assert force.max() <= K * abs(strain) * (1 + 1e-6)


def test_particles_on_a_line_are_pushed_off_it_with_full_force(system):
    line = np.linspace(0, 1, 4)[:, None] * [1.0, 2.0, 3.0]
    for points in (line, line[[2, 0, 3, 1]], line[[0, 0, 1, 1]], line[[0, 1, 1, 1]], line[[1, 1, 1, 0]]):
        force = _apply(system, points).force
        assert np.linalg.norm(force, axis=1).sum() == pytest.approx(2 * K), "k on either side"
        np.testing.assert_allclose(force.sum(0), 0, atol=1e-12)
        np.testing.assert_allclose(force @ [1.0, 2.0, 3.0], 0, atol=1e-5)


def test_flat_tetrahedra_have_no_altitude_spring(system):
    s = _apply(system, REST, REST * [1, 1, 0])
    assert np.all(s.force == 0) and np.all(s.A == 0)


def test_particles_in_one_place_get_no_force(system):
    s = _apply(system, np.ones((4, 3)))
    assert np.all(s.force == 0) and np.all(s.A == 0)
