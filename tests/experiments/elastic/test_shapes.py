"""What there is to simulate has the shape it should."""

import numpy as np

from hairpipe.graphs.experiments.elastic import mesh_geometry
from hairpipe.graphs.experiments.elastic.hinges import boundary, hinges
from hairpipe.graphs.experiments.elastic.sheets import build_cloth, build_noodle
from hairpipe.graphs.experiments.elastic.torus import build_torus


def directed(triangles):
    return {(a, b) for t in triangles.tolist() for a, b in zip(t, t[1:] + t[:1], strict=True)}


def test_torus_is_filled_with_upright_tetrahedra():
    solid = build_torus(0.5, 0.2, 3, 40, 1.6)
    volume = mesh_geometry.volumes(solid.points, solid.tetrahedra)
    assert volume.min() > 0 and 1.6 <= solid.points[:, 1].min() < 1.605
    exact = 2 * np.pi**2 * 0.5 * 0.2**2
    polygon = 6 * 3 * np.sin(2 * np.pi / 18) / 2 * 2 / (2 * np.pi)
    assert abs(volume.sum() / exact - polygon) < 0.01


def test_surface_of_the_torus_is_closed_and_looks_outward():
    solid = build_torus(0.5, 0.2, 2, 24, 0.0)
    surface = boundary(solid.tetrahedra)
    edges = directed(surface)
    assert len(edges) == 3 * len(surface) and edges == {(b, a) for a, b in edges}
    assert len(set(surface.ravel())) - len(edges) // 2 + len(surface) == 0, "a torus has Euler characteristic 0"
    a, b, c = (solid.points[surface[:, i]] for i in range(3))
    inside = np.sum(np.cross(b, c) * a) / 6
    np.testing.assert_allclose(inside, mesh_geometry.volumes(solid.points, solid.tetrahedra).sum(), rtol=1e-12)


def test_shells_are_turned_one_way():
    for shell in (build_noodle(0.5, 0.15, 8, 6, 1.0), build_cloth(1.0, 5, 1.0)):
        assert len(directed(shell.triangles)) == 3 * len(shell.triangles)


def test_hinges_are_the_inner_edges():
    cloth = build_cloth(1.0, 6, 1.0)
    fours = hinges(cloth.triangles)
    assert len(fours) == 2 * 6 * 5 + 6 * 6
    triangles = {frozenset(t) for t in cloth.triangles.tolist()}
    assert {frozenset(f[[0, 1, 2]].tolist()) for f in fours} | {
        frozenset(f[[0, 1, 3]].tolist()) for f in fours
    } == triangles
    assert cloth.pinned.sum() == 2


def test_angles_of_a_tube_are_those_of_its_polygon():
    noodle = build_noodle(50.0, 0.15, 400, 12, 0.0)
    bent = np.degrees(mesh_geometry.angles(noodle.points, hinges(noodle.triangles)))
    bent = np.abs(bent)[np.abs(bent) > 20]
    np.testing.assert_allclose(bent, 30.0, atol=0.5)
    assert len(bent) == 400 * 12


def test_altitudes_of_a_regular_tetrahedron():
    points = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    heights = mesh_geometry.altitudes(points, np.array([[0, 1, 2, 3]]))[0]
    np.testing.assert_allclose(np.abs(heights), [4 / np.sqrt(3)] * 4 + [2.0] * 3)
    assert len(set(np.sign(heights))) == 1
    np.testing.assert_allclose(np.abs(mesh_geometry.volumes(points, np.array([[0, 1, 2, 3]]))), 8 / 3)
