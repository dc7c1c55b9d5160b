"""Forces and stiffness of a whole rod against differences of its energy, which is written down in numpy."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.frames import DIRECTOR, TENSION, TWIST
from hairpipe.geometry.simd import store
from hairpipe.solve.sag_free import assemble
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.interface import StiffnessPart, least_pivot
from hairpipe.strands.material import Diameter, Material, VariedMaterial

from ...laws.checks import check_law

EXTENDED = np.longdouble
PLACES = 0, 11, 21, 30


class Bent:
    """A rod of a few segments, strongly bent, twisted and stretched; the buried edge and its frame move, too."""

    def __init__(self, scene, straight):
        self.hair = scene([straight(0.05, 5, [0.3, -1, 0.4])], model="rod").hair
        rng = np.random.default_rng(1)
        self.x = self.hair.rest + 0.004 * rng.normal(size=self.hair.rest.shape[:2])[:, :, None]
        self.T = np.zeros_like(self.hair.model.inverse_lengths)
        self.T[2:-2, TWIST] = rng.normal(size=len(self.x) - 4)[:, None]
        model = self.hair.model
        model.inverse_lengths[2:-2, 1:4] = 0.3 * rng.normal(size=(len(self.x) - 4, 3))[:, :, None]
        self.scale = 1 / model.scale[0, 0, 0]
        lengths = np.linalg.norm(np.diff(self.x[1:-1], axis=0), axis=1)
        self.T[1:-2, TENSION] = model.constants[1:-2, 0] * (lengths * model.inverse_lengths[1:-2, 0] - 1)
        self.A, self.b = assemble(model, 0, self.x, self.T, int(StiffnessPart.exact))

    def energy(self, nodes, angles):
        """Energy [J] as nodes move by (n, 3) [m] and edges turn by (n-1,) [rad], their frames carried along."""
        base, rest = self.x[1:-1, :, 0].astype(EXTENDED), self.hair.model.inverse_lengths[1:-1, :, 0].astype(EXTENDED)
        before, edges = unit(np.diff(base, axis=0)), np.diff(base + nodes, axis=0)
        lengths, t = np.linalg.norm(edges, axis=1), unit(edges)
        m = self.T[1:-2, DIRECTOR : DIRECTOR + 3, 0].astype(EXTENDED)
        first = self.x[0, :, 0] - base[0]
        m[0] = unit((first - (first @ before[0]) * before[0])[None])[0]
        m = transport(m, before, t)
        m = np.cos(angles)[:, None] * m + np.sin(angles)[:, None] * np.cross(t, m)
        te, tf, m1e, m1f = t[:-1], t[1:], m[:-1], m[1:]
        m2 = np.cross(te, m1e) + np.cross(tf, m1f)
        kb = 2 * np.cross(te, tf) / (1 + np.sum(te * tf, axis=1, keepdims=True))
        over = transport(m1e, te, tf)
        psi = np.arctan2(np.sum(np.cross(over, m1f) * tf, axis=1), np.sum(over * m1f, axis=1))
        k1, k2 = np.sum(m2 * kb, axis=1) / 2, -np.sum((m1e + m1f) * kb, axis=1) / 2
        bend, twist = rest[1:-1, 4], rest[1:-1, 5]
        bent = bend * ((k1 - rest[1:-1, 1]) ** 2 + (k2 - rest[1:-1, 2]) ** 2) + twist * (psi - rest[1:-1, 3]) ** 2
        stretched = self.hair.model.constants[1:-2, 0, 0] * (lengths - 1 / rest[:-1, 0]) ** 2 * rest[:-1, 0]
        return (np.sum(bent) + np.sum(stretched[1:])) / 2  # the buried edge has no energy

    def energy_at(self, u):
        """The same by the unknowns of rows [m], (rows of nodes x 4,)."""
        rows = u.reshape(-1, 4)
        return self.energy(rows[:, :3], rows[:-1, 3] / self.scale)


def unit(a):
    return a / np.sqrt(np.sum(a**2, axis=1, keepdims=True))


def transport(m, start, end):
    return m - np.sum(end * m, axis=1, keepdims=True) / (1 + np.sum(start * end, axis=1, keepdims=True)) * (start + end)


def dense_of(A):
    """The matrix of the nodes and the edges between them, (28, 28)."""
    dense = np.zeros((40, 40))
    for p, row in enumerate(A[1:-1, :, 0]):
        for j, place in enumerate(PLACES):
            dense[4 * p + j, 4 * p + j : 4 * p + 11] = row[place : place + 11 - j]
    dense[27, 27] = 0.0  # the last node has no edge
    return (dense + np.triu(dense, 1).T)[:28, :28]


@pytest.fixture
def bent(scene, straight):
    return Bent(scene, straight)


def test_forces_and_tangent_are_the_derivatives_of_the_energy(bent):
    force, steps = bent.b[1:-1, :, 0].reshape(-1), (1e-7, 1e-6)
    check_law(bent.energy_at, lambda _: force, dense_of(bent.A), np.zeros(28), steps=steps, free=False)


def test_inner_forces_have_neither_resultant_nor_moment(bent):
    """A rigid turn takes the frames along: the torque about every edge counts."""
    f, x = bent.b[1:-1, :3, 0], bent.x[1:-1, :, 0]
    tangents = unit(np.diff(x, axis=0))
    moment = np.cross(x, f).sum(0) + (bent.b[1:-2, 3, 0, None] * bent.scale * tangents).sum(0)
    assert np.abs(f.sum(0)).max() < 1e-12 * np.abs(f).max()
    assert np.abs(moment).max() < 1e-12 * np.abs(np.cross(x, f)).max()


def test_the_projected_tangent_is_semidefinite_and_the_full_one_is_not(bent):
    lowest = []
    for part in (StiffnessPart.projected, StiffnessPart.full):
        A, _ = assemble(bent.hair.model, 0, bent.x, bent.T, int(part))
        values = np.linalg.eigvalsh(dense_of(A))
        lowest.append(values[0] / values[-1])
    assert lowest[0] > -1e-12 and lowest[1] < -1e-6


@njit
def _least(model, hh, out):
    store(out, (0,), least_pivot(model, np.int64(0), hh))


@pytest.mark.parametrize("tip", [1.0, 0.2])
def test_the_least_pivot_is_a_quarter_of_that_of_a_straight_rod(scene, straight, tip):
    """It is that of the last angle: all vertices are springs in series there, also where the hair is tapered."""
    material = VariedMaterial(diameter=Diameter(80e-6, profile=((0.0, 1.0), (1.0, tip))))
    hair = build_hair(scene([straight(0.25, 50, [0.3, -1, 0.4])]).hair.groom, material, "rod")
    A, _ = assemble(hair.model, 0, hair.rest, np.zeros_like(hair.model.inverse_lengths), int(StiffnessPart.exact))
    twists = np.diag(A[2:-2, PLACES[3], 0])
    twists += np.diag(A[2:-3, PLACES[3] + 4, 0], 1) + np.diag(A[2:-3, PLACES[3] + 4, 0], -1)
    bound = np.zeros((1, hair.rest.shape[-1]))
    _least(hair.model, 1.0, bound)
    assert bound[0, 0] == pytest.approx(0.25 / np.linalg.inv(twists)[-1, -1], rel=1e-6)


def test_a_strand_has_the_mass_of_its_segments(bent):
    np.testing.assert_allclose(bent.hair.model.mass[2:, 0].sum(), Material().line_density * 0.05, rtol=1e-12)
