import numpy as np

from hairpipe.body.bust import relax
from hairpipe.geometry.isosurface import extract_surface

AXES = (np.linspace(-1.2, 1.2, 25),) * 3


def rough_ball() -> tuple[np.ndarray, np.ndarray]:
    x, y, z = np.meshgrid(*AXES, indexing="ij")
    return extract_surface(np.sqrt(x * x + y * y + z * z) - 0.9, AXES)


def onto_ball(points: np.ndarray) -> np.ndarray:
    return 0.9 * points / np.linalg.norm(points, axis=1, keepdims=True)


def test_relaxing_keeps_the_surface_and_evens_the_triangles(measure_mesh):
    points, triangles = rough_ball()
    before = onto_ball(points)
    after = relax(before, triangles, onto_ball, rounds=8)
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), 0.9, rtol=1e-12)
    worst = [np.percentile(measure_mesh(p, triangles)["shape"], 1.0) for p in (before, after)]
    assert worst[1] > worst[0]
    assert measure_mesh(after, triangles)["volume"] > 0.99 * measure_mesh(before, triangles)["volume"]
