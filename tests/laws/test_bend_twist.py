"""Laws of the measures of a vertex and of their derivatives, against differences of the definitions in numpy."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.simd import WIDTH, load, store
from hairpipe.laws.bend_twist import bend, force_of, geometric, gradients, semidefinite, stretch_of, sum_of

from .checks import check_law

STIFFNESS, NATURAL = np.array([2.0, 2.0, 1.3]), np.array([0.3, -0.2, 0.1])
E, F = np.array([0.4, 0.7, 0.2]), np.array([-0.1, 0.8, 0.75])
DIRECTORS = np.array([1.0, 0.1, -0.2]), np.array([0.3, 1.0, 0.4])


def unit(a):
    return a / np.sqrt(a @ a)


def across(m, t):
    return unit(m - (m @ t) * t)


def transport(m, start, end):
    return m - (end @ m) / (1 + start @ end) * (start + end)


def measures(e, f, m1e, m1f):
    """k1, k2 and psi by their definitions."""
    te, tf = unit(e), unit(f)
    m2e, m2f = np.cross(te, m1e), np.cross(tf, m1f)
    kb = 2 * np.cross(te, tf) / (1 + te @ tf)
    over = transport(m1e, te, tf)
    psi = np.arctan2(np.cross(over, m1f) @ tf, over @ m1f)
    return np.array([(m2e + m2f) @ kb / 2, -(m1e + m1f) @ kb / 2, psi])


def energy(u):
    """Of a vertex whose edges were changed by u (e, th_e, f, th_f), its frames carried along."""
    frames = []
    for edge, m, du in ((E, DIRECTORS[0], u[:4]), (F, DIRECTORS[1], u[4:])):
        start, end = unit(edge.astype(u.dtype)), unit(edge + du[:3])
        m = transport(across(m.astype(u.dtype), start), start, end)
        frames.append(np.cos(du[3]) * m + np.sin(du[3]) * np.cross(end, m))
    return np.sum(STIFFNESS * (measures(E + u[:3], F + u[4:7], *frames) - NATURAL) ** 2) / 2


@njit
def derive(edges, stiffness, moments, out, second, projected):
    e = load(edges, (0,)), load(edges, (1,)), load(edges, (2,))
    f = load(edges, (3,)), load(edges, (4,)), load(edges, (5,))
    m = load(edges, (6,)), load(edges, (7,)), load(edges, (8,))
    n = load(edges, (9,)), load(edges, (10,)), load(edges, (11,))
    v = bend(e, f, load(edges, (12,)), load(edges, (13,)), m, n)
    q = load(moments, (0,)), load(moments, (1,)), load(moments, (2,))
    g1, g2, g3 = gradients(v)
    g = force_of(q, (g1, g2, g3))
    for c in range(3):
        store(out, (c,), g.e[c])
        store(out, (4 + c,), g.f[c])
    store(out, (3,), g.a)
    store(out, (7,), g.b)
    H = sum_of(sum_of(stretch_of(stiffness[0], g1), stretch_of(stiffness[1], g2)), stretch_of(stiffness[2], g3))
    H = sum_of(H, geometric(q, v))
    write(H, second)
    write(semidefinite(H, second), projected)


@njit
def write(H, second):
    for c in range(6):
        store(second, (c,), H.ee[c])
        store(second, (6 + c,), H.ff[c])
    for c in range(9):
        store(second, (12 + c,), H.ef[c])
    for c in range(3):
        store(second, (21 + c,), H.e_a[c])
        store(second, (24 + c,), H.e_b[c])
        store(second, (27 + c,), H.f_a[c])
        store(second, (30 + c,), H.f_b[c])
    store(second, (33,), H.aa)
    store(second, (34,), H.ab)
    store(second, (35,), H.bb)


def derivatives(natural=NATURAL):
    """Gradient (8,), second derivative (8, 8), and its semidefinite part, by the kernels."""
    te, tf = unit(E), unit(F)
    m, n = across(DIRECTORS[0], te), across(DIRECTORS[1], tf)
    edges = np.concatenate([te, tf, m, n, [1 / np.sqrt(E @ E), 1 / np.sqrt(F @ F)]])
    moments = STIFFNESS * (measures(E, F, m, n) - natural)
    lanes = [np.repeat(a[:, None], WIDTH, axis=1) for a in (edges, moments)]
    out, second, projected = np.empty((8, WIDTH)), np.empty((36, WIDTH)), np.empty((36, WIDTH))
    derive(lanes[0], STIFFNESS, lanes[1], out, second, projected)
    return out[:, 0], dense(second[:, 0]), dense(projected[:, 0])


def dense(s):
    """The matrix of 36 numbers, (8, 8)."""
    H = np.zeros((8, 8))
    e, f = slice(0, 3), slice(4, 7)
    for part, six in ((e, s[:6]), (f, s[6:12])):
        upper = np.zeros((3, 3))
        upper[np.triu_indices(3)] = six
        H[part, part] = upper + np.triu(upper, 1).T
    H[e, f] = s[12:21].reshape(3, 3)
    H[e, 3], H[e, 7], H[f, 3], H[f, 7] = s[21:24], s[24:27], s[27:30], s[30:33]
    H[f, e], H[3, e], H[7, e], H[3, f], H[7, f] = H[e, f].T, H[e, 3], H[e, 7], H[f, 3], H[f, 7]
    H[3, 3], H[3, 7], H[7, 3], H[7, 7] = s[33], s[34], s[34], s[35]
    return H


def test_gradient_and_tangent_are_the_derivatives_of_the_energy():
    gradient, tangent, _ = derivatives()
    check_law(energy, lambda _: -gradient, tangent, np.zeros(8), free=False)


@pytest.mark.parametrize("natural", [(3.0, -2.0, 1.0), (-3.0, 2.0, 1.0), (-4.0, -3.0, -2.0), (2.0, 5.0, -1.0)])
def test_the_semidefinite_part_has_the_positive_eigenvalues_alone(natural):
    _, H, projected = derivatives(np.array(natural))
    values, vectors = np.linalg.eigh(H)
    assert values[0] < -1.0 and values[-1] > 1.0
    np.testing.assert_allclose(projected, (vectors * np.maximum(values, 0.0)) @ vectors.T, atol=1e-9)
