import numpy as np
import pytest

from hairpipe.body.isosurface import extract_surface, split_quads

AXES = (np.linspace(-1.2, 1.2, 41), np.linspace(-1.3, 1.3, 45) ** 3 / 1.69, np.linspace(-1.1, 1.25, 37))


def sample(field) -> np.ndarray:
    return field(*np.meshgrid(*AXES, indexing="ij"))


def test_ball_is_closed_outward_and_has_its_volume(measure_mesh):
    points, triangles = extract_surface(sample(lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 0.9), AXES)
    facts = measure_mesh(points, triangles)
    assert facts["closed"] and facts["euler"] == 2
    assert facts["volume"] == pytest.approx(4.0 / 3.0 * np.pi * 0.9**3, rel=0.02)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.9, atol=0.02)


def test_torus_has_one_hole(measure_mesh):
    torus = sample(lambda x, y, z: np.hypot(np.hypot(x, y) - 0.6, z) - 0.25)
    facts = measure_mesh(*extract_surface(torus, AXES))
    assert facts["closed"] and facts["euler"] == 0
    assert facts["volume"] == pytest.approx(2.0 * np.pi**2 * 0.6 * 0.25**2, rel=0.05)


def test_flat_faces_are_reproduced_exactly():
    cube = sample(lambda x, y, z: np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - 0.73)
    points, _ = extract_surface(cube, AXES)
    on_faces = (np.sort(np.abs(points), axis=1)[:, 1] < 0.6).nonzero()[0]
    assert len(on_faces) > 500
    np.testing.assert_allclose(np.abs(points[on_faces]).max(axis=1), 0.73, atol=1e-12)


def test_quads_are_cut_along_the_shorter_diagonal():
    points = np.array([[0.0, 0, 0], [3, 0, 0], [4, 1, 0], [1, 1, 0]])
    triangles = split_quads(points, np.array([[0, 1, 2, 3]]))
    assert {frozenset(t) for t in triangles.tolist()} == {frozenset({0, 1, 3}), frozenset({1, 2, 3})}
    assert triangles.dtype == np.int32
