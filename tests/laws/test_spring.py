"""Laws of the implicit linear spring."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.simd import load, store
from hairpipe.laws.stretch import critical_damping, linearise_spring, multiplier, tension
from hairpipe.strands.assembly import add_spring

from .checks import check_law

K, REST, STEP = 3.0, 0.8, 0.5


@njit
def _add(A, b, x, v, T, offset, c, h, hh):
    one = 0.0 * load(x, (0, 0)) + 1.0
    add_spring(A, b, 0, offset, linearise_spring((x, v, T), 0, offset, (K * one, one / REST, c * one), h, hh))


def _apply(system, points, offset, tension=0.0, *, v=None, c=0.0, h=1.0, hh=1.0):
    s = system(points)
    s.T[0, offset - 1] = tension
    if v is not None:
        s.v[:] = v[:, :, None]
    _add(s.A, s.b, s.x, s.v, s.T, offset, c, h, hh)
    return s


@pytest.mark.parametrize("offset", [1, 2, 3])
def test_it_keeps_the_laws_of_its_energy(system, offset):
    """Stiffness is exact with the spring's own tension; on a compressed one it has none."""
    points = np.random.default_rng(offset).normal(size=(4, 3)) * [1, 3, 2]

    def energy(x):
        return K / 2 * (np.sqrt(np.sum((x[offset] - x[0]) ** 2)) - REST) ** 2 / REST

    own = K * (np.linalg.norm(points[offset] - points[0]) / REST - 1)
    assert own > 0
    stiffness = _apply(system, points, offset, own).stiffness
    check_law(energy, lambda x: _apply(system, x, offset).force, stiffness, points)


def test_compression_leaves_stiffness_positive_semidefinite(system):
    points = np.random.default_rng(5).normal(size=(4, 3))
    eigenvalues = np.linalg.eigvalsh(_apply(system, points, 2, tension=-10.0).stiffness)
    assert eigenvalues.min() > -1e-12


def test_damping_resists_what_changes_the_length_alone(system):
    """h f and h D, D = c d d^T: linear in the velocities, and nothing from a turn."""
    points, v = np.random.default_rng(8).normal(size=(2, 4, 3))
    d = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    still, moving = (_apply(system, points, 1, v=u, c=2.0, h=STEP, hh=0.0) for u in (0 * v, v))
    change = (moving.force - still.force).reshape(-1)
    np.testing.assert_allclose(change[:3], STEP * 2.0 * (d @ (v[1] - v[0])) * d, rtol=1e-12)
    np.testing.assert_allclose(change, -moving.stiffness @ v.reshape(-1), atol=1e-13)
    turning = np.cross([0.3, -1.0, 2.0], points)
    np.testing.assert_allclose(
        _apply(system, points, 1, v=turning, c=2.0, h=STEP, hh=0.0).force, still.force, atol=1e-13
    )


def test_an_explicit_spring_has_no_stiffness(system):
    points = np.random.default_rng(9).normal(size=(4, 3))
    s = _apply(system, points, 1, tension=5.0, hh=0.0)
    assert np.all(s.A == 0) and np.abs(s.force).max() > 0


def test_critical_damping_is_that_of_two_masses_on_a_spring():
    """x'' + (c / m) x' + k / (m l0) x = 0 with the reduced mass m has a double root."""
    mass = np.array([[0.2], [0.3]]) * np.ones(8)
    out = np.empty((1, 8))
    _critical(mass, out)
    reduced = 0.2 * 0.3 / 0.5
    roots = np.roots([reduced, out[0, 0], K / REST])
    np.testing.assert_allclose(roots, -out[0, 0] / (2 * reduced), rtol=1e-6)


@njit
def _critical(mass, out):
    one = 0.0 * load(mass, (0,)) + 1.0
    store(out, (0,), critical_damping(K * one, one / REST, mass, 0, 1))


@njit
def _tensions(x, dx, p, offset, out):
    store(out, (0,), multiplier(x, dx, p, offset, K, 1 / REST))
    store(out, (1,), tension(x, p, offset, K, 1 / REST))


@pytest.mark.parametrize(("p", "offset"), [(0, 2), (1, 1), (1, 2)])
def test_the_multiplier_is_the_linearised_tension(p, offset):
    x, dx = np.random.default_rng(7).normal(size=(2, 4, 3))
    out = np.empty((2, 8))
    _tensions(*(np.repeat(a[:, :, None], 8, axis=2) for a in (x, dx)), p, offset, out)
    d, moved = x[p + offset] - x[p], dx[p + offset] - dx[p]
    length = np.linalg.norm(d)
    np.testing.assert_allclose(out[0], K * (d @ (d + moved) / length / REST - 1))
    np.testing.assert_allclose(out[1], K * (length / REST - 1))
