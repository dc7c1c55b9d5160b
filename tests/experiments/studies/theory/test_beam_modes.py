"""Frequencies of a clamped rod."""

import numpy as np
from scipy.integrate import trapezoid

from hairpipe.graphs.experiments.studies.theory.beam_modes import bending_frequencies, bending_roots, bending_shape


def test_roots_are_those_of_the_tables():
    np.testing.assert_allclose(bending_roots(4), [1.8751041, 4.6940911, 7.8547574, 10.9955407], atol=1e-7)


def test_frequencies_are_eigenvalues_of_a_finely_divided_rod():
    """Cubic (Hermite) elements of EI y'''' = rho A w^2 y, clamped at one end."""
    length, bending, density, elements = 0.3, 8e-9, 6.5e-6, 20
    h = length / elements
    stiff = bending / h**3 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    mass = density * h / 420 * np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    K, M = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for e in range(0, 2 * elements, 2):
        K[e : e + 4, e : e + 4] += stiff
        M[e : e + 4, e : e + 4] += mass
    omega = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M[2:, 2:], K[2:, 2:])).real)[:3])
    np.testing.assert_allclose(bending_frequencies(3, length, bending, density), omega / 2 / np.pi, rtol=3e-5)


def test_shapes_swing_free_at_the_tip_and_are_orthogonal():
    s = np.linspace(0, 1, 4001)
    shapes = np.array([bending_shape(mode, s) for mode in range(3)])
    products = trapezoid(shapes[:, None] * shapes[None], s)
    np.testing.assert_allclose(products, np.eye(3), atol=1e-6)
    bends = np.gradient(np.gradient(shapes, s, axis=1), s, axis=1)
    assert np.abs(bends[:, -3]).max() < 0.05 * np.abs(bends).max()
