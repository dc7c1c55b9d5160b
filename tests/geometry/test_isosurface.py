import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hairpipe.geometry.isosurface import extract_surface, split_quads

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


@given(st.integers(0, 10_000), st.floats(-1.0, 1.0))
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_field_gives_closed_manifold_surfaces(measure_mesh, seed, level):
    values = np.random.default_rng(seed).normal(size=(7, 6, 8)) + level
    for axis in range(3):
        values = np.moveaxis(values, axis, 0)
        values[[0, -1]] = 1.0
        values = np.moveaxis(values, 0, axis)
    points, triangles = extract_surface(values, tuple(np.arange(n, dtype=float) for n in values.shape))
    if len(triangles):
        facts = measure_mesh(points, triangles)
        assert facts["closed"] and facts["volume"] > 0.0
        assert fans_are_single(triangles, len(points))


def fans_are_single(triangles: np.ndarray, count: int) -> bool:
    """Whether the triangles about every vertex form one ring: no two sheets touch in a point."""
    follower = {(a, b): c for t in triangles.tolist() for a, b, c in (t, t[1:] + t[:1], t[2:] + t[:2])}
    degree = np.bincount(triangles.ravel(), minlength=count)
    for vertex in range(count):
        start = current = next(b for (a, b) in follower if a == vertex)
        steps = 0
        while steps == 0 or current != start:
            current, steps = follower[vertex, current], steps + 1
        if steps != degree[vertex]:
            return False
    return True
