"""Forces and matrix of a mesh of springs, its material, and its solution."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.elastic.block_pcg import solve
from hairpipe.graphs.experiments.elastic.matter import Fabric, Rubber
from hairpipe.graphs.experiments.elastic.sheets import build_noodle
from hairpipe.graphs.experiments.elastic.spring_assembly import add_altitudes, add_linear, find_tensions, spring_energy
from hairpipe.graphs.experiments.elastic.spring_mesh import shell_springs, solid_springs
from hairpipe.graphs.experiments.elastic.torus import build_torus

from ...laws.checks import check_balance, check_law
from .conftest import dense, hexagons


def forces(springs, x, v=None, damping=0.0, h=1.0, tension=False):
    """Force (n, 3) and blocks of the matrix."""
    A, b = np.zeros((len(springs.pattern.column), 3, 3)), np.zeros_like(x)
    v, T = np.zeros_like(x) if v is None else v, np.zeros(len(springs.pairs))
    if tension:
        find_tensions(T, x, np.zeros_like(x), springs)
    add_linear(A, b, x, v, T, springs, h, damping)
    add_altitudes(A, b, x, v, springs, h, damping)
    return b, A


@pytest.fixture(params=["selected", "none"])
def solid(request, block):
    return solid_springs(block, Rubber(10.0, 1.0, altitudes=request.param)), block.points


def check_springs(springs, x):
    def energy(points):
        return spring_energy(points.astype(float), springs)

    check_law(energy, lambda points: forces(springs, points)[0], None, x, rtol=1e-5, atol=1e-7, steps=(1e-6, 0.0))
    force, _ = forces(springs, x, np.random.default_rng(4).normal(size=x.shape), damping=0.3)
    check_balance(x, force)


def test_springs_keep_the_laws_of_their_energy(solid):
    springs, points = solid
    check_springs(springs, points + 0.15 * np.random.default_rng(1).normal(size=points.shape))


def test_so_do_those_of_a_shell():
    shell = build_noodle(1.0, 0.3, 4, 6, 0.0)
    x = shell.points + 0.02 * np.random.default_rng(2).normal(size=shell.points.shape)
    check_springs(shell_springs(shell, Fabric(100.0, 0.1, 1.0)), x)


def test_at_rest_nothing_acts(solid):
    springs, points = solid
    np.testing.assert_allclose(forces(springs, points)[0], 0, atol=1e-13)


def test_matrix_is_symmetric_and_positive(solid):
    springs, points = solid
    x = points + 0.2 * np.random.default_rng(5).normal(size=points.shape)
    full = dense(forces(springs, x, tension=True)[1], springs.pattern)
    np.testing.assert_allclose(full, full.T, atol=1e-12)
    assert np.linalg.eigvalsh(full).min() > -1e-10


def test_matrix_is_the_slope_of_the_force_at_rest(block):
    springs = solid_springs(block, Rubber(10.0, 1.0))
    full = dense(forces(springs, block.points)[1], springs.pattern)
    change = np.random.default_rng(6).normal(size=block.points.shape)
    slope = (forces(springs, block.points + 1e-7 * change)[0] - forces(springs, block.points - 1e-7 * change)[0]) / 2e-7
    # At rest several altitudes of these tetrahedra tie, and all have their rest height: any of them gives a force.
    assert full.shape == (81, 81) and np.sum(slope * change) < 0 < change.ravel() @ full @ change.ravel()
    none = solid_springs(block, Rubber(10.0, 1.0, altitudes="none"))
    full = dense(forces(none, block.points)[1], none.pattern)
    slope = (forces(none, block.points + 1e-7 * change)[0] - forces(none, block.points - 1e-7 * change)[0]) / 2e-7
    np.testing.assert_allclose(-full @ change.ravel(), slope.ravel(), rtol=1e-5, atol=1e-6)


def test_damping_resists_a_change_of_shape_only(solid):
    springs, points = solid
    turning = np.cross([0.3, 1.0, -0.5], points) + np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(forces(springs, points, turning, damping=1.0)[0], 0, atol=1e-12)
    v = np.random.default_rng(7).normal(size=points.shape)
    assert np.sum(forces(springs, points, v, damping=1.0)[0] * v) < 0


@pytest.mark.parametrize("held", [False, True])
def test_solution_is_for_free_unknowns(block, held):
    springs = solid_springs(block, Rubber(10.0, 1.0))
    rng = np.random.default_rng(1)
    x = block.points + 0.1 * rng.normal(size=block.points.shape)
    A, b = np.zeros((len(springs.pattern.column), 3, 3)), rng.normal(size=x.shape)
    A[springs.pattern.diagonal] = np.eye(3)
    add_linear(A, np.zeros_like(x), x, 0 * x, np.zeros(len(springs.pairs)), springs, 1.0, 0.0)
    add_altitudes(A, np.zeros_like(x), x, 0 * x, springs, 1.0, 0.0)
    free = np.ones_like(x)
    if held:
        free[rng.random(x.shape) < 0.3] = 0.0
    found, residual, made = solve(A, b, springs.pattern, free, 1e-12, 500)
    full, keep = dense(A, springs.pattern), free.ravel() > 0
    exact = np.zeros(x.size)
    exact[keep] = np.linalg.solve(full[np.ix_(keep, keep)], b.ravel()[keep])
    np.testing.assert_allclose(found.ravel(), exact, atol=1e-9)
    np.testing.assert_allclose(residual.ravel(), full @ exact - b.ravel(), atol=1e-8)
    assert 0 < made < 200


STRAIN = 1e-4


def averaged(energy, points):
    """Mean over the directions of an icosahedron of the energy of a small stretch, over strain^2 / 2."""
    golden = (1 + np.sqrt(5)) / 2
    axes = np.array([[0, 1, golden], [0, 1, -golden], [1, golden, 0], [1, -golden, 0], [golden, 0, 1], [golden, 0, -1]])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return np.mean([energy(points @ (np.eye(3) + STRAIN * np.outer(n, n))) for n in axes]) / (STRAIN**2 / 2)


def test_edges_of_a_solid_are_a_material_of_poisson_ratio_one_quarter():
    """C_1111 = E (1 - nu) / ((1 + nu) (1 - 2 nu)) = 6/5 E, exact in the mean over all directions."""
    solid = build_torus(0.5, 0.2, 2, 16, 0.0)
    springs = solid_springs(solid, Rubber(2e5, 1000.0, altitudes="none"))
    volume = springs.mass.sum() / 1000.0
    assert averaged(lambda x: spring_energy(x, springs), solid.points) / volume == pytest.approx(1.2 * 2e5, rel=1e-3)


def test_edges_of_a_sheet_are_a_material_of_poisson_ratio_one_third():
    shell = hexagons()
    springs = shell_springs(shell, Fabric(1e6, 1e-3, 500.0, across=0.0))
    area = springs.mass.sum() / 0.5
    stretched = shell.points * [1 + STRAIN, 1, 1]
    modulus = spring_energy(stretched, springs) / (STRAIN**2 / 2) / area
    assert modulus == pytest.approx(1e6 * 1e-3 / (1 - 1 / 9), rel=0.01)


def test_a_sheet_bends_like_a_plate():
    """Rolled on a cylinder: D / (2 R^2) per area, D = E t^3 / (12 (1 - 1/9))."""
    shell, radius = hexagons(), 1.0
    springs = shell_springs(shell, Fabric(1e6, 1e-3, 500.0, across=0.0, altitudes="selected"))
    area = springs.mass.sum() / 0.5
    bending = springs._replace(pulls=0 * springs.pulls)
    for axis in (0, 2):
        s = shell.points[:, axis] / radius
        rolled = shell.points.copy()
        rolled[:, axis], rolled[:, 1] = radius * np.sin(s), radius * np.cos(s)
        energy = spring_energy(rolled, bending) / area
        assert energy == pytest.approx(1e6 * 1e-9 / (12 * (1 - 1 / 9)) / 2 / radius**2, rel=0.1)


def test_mass_is_that_of_the_matter():
    solid = build_torus(0.5, 0.2, 4, 60, 0.0)
    assert solid_springs(solid, Rubber(density=500.0)).mass.sum() == pytest.approx(500 * 0.3948, rel=0.02)
    shell = hexagons(4, 4, 0.1)
    assert shell_springs(shell, Fabric(thickness=0.01, density=100.0)).mass.sum() == pytest.approx(
        16 * 2 * 0.00433, rel=1e-3
    )
