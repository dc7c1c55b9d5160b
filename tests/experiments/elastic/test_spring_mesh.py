"""Springs make the material that they are asked to."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.elastic.matter import Fabric, Rubber
from hairpipe.graphs.experiments.elastic.spring_assembly import spring_energy
from hairpipe.graphs.experiments.elastic.spring_mesh import shell_springs, solid_springs
from hairpipe.graphs.experiments.elastic.torus import build_torus

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


def test_edges_of_a_sheet_are_a_material_of_poisson_ratio_one_third(hexagons):
    shell = hexagons()
    springs = shell_springs(shell, Fabric(1e6, 1e-3, 500.0, across=0.0))
    area = springs.mass.sum() / 0.5
    stretched = shell.points * [1 + STRAIN, 1, 1]
    modulus = spring_energy(stretched, springs) / (STRAIN**2 / 2) / area
    assert modulus == pytest.approx(1e6 * 1e-3 / (1 - 1 / 9), rel=0.01)


def test_a_sheet_bends_like_a_plate(hexagons):
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


def test_mass_is_that_of_the_matter(hexagons):
    solid = build_torus(0.5, 0.2, 4, 60, 0.0)
    assert solid_springs(solid, Rubber(density=500.0)).mass.sum() == pytest.approx(500 * 0.3948, rel=0.02)
    shell = hexagons(4, 4, 0.1)
    assert shell_springs(shell, Fabric(thickness=0.01, density=100.0)).mass.sum() == pytest.approx(
        16 * 2 * 0.00433, rel=1e-3
    )
