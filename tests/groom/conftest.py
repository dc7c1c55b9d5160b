"""Bodies to grow hair on, small enough to know everything about."""

from collections.abc import Callable, Iterator

import numba
import numpy as np
import pytest

from hairpipe.data import Body, Mesh, Skeleton

GOLDEN = (1.0 + 5.0**0.5) / 2.0
Values = Callable[[np.ndarray], np.ndarray]


def make_icosphere(level: int, radius: float) -> Mesh:
    """An icosahedron, every triangle cut into 4^level, blown up to a sphere about the origin."""
    corners = [(0, a, b) for a in (-1, 1) for b in (-GOLDEN, GOLDEN)]
    points = np.array([np.roll(corner, turn) for turn in range(3) for corner in corners], dtype=float)
    edges = np.linalg.norm(points[:, None] - points[None], axis=2) < 2.1
    triangles = [
        (a, b, c) if np.linalg.det(points[[a, b, c]]) > 0 else (a, c, b)
        for a in range(12)
        for b in range(a)
        for c in range(b)
        if edges[a, b] and edges[b, c] and edges[a, c]
    ]
    points, triangles = points / np.linalg.norm(points[0]), np.array(triangles)
    for _ in range(level):
        points, triangles = refine(points, triangles)
    return Mesh(np.ascontiguousarray(points * radius), triangles.astype(np.int32))


def refine(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = triangles.T
    halves = np.sort(np.concatenate([np.stack(pair, axis=1) for pair in ((b, c), (c, a), (a, b))]), axis=1)
    edges, where = np.unique(halves, axis=0, return_inverse=True)
    x, y, z = len(points) + where.reshape(3, -1)
    middle = points[edges].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    parts = ((a, z, y), (b, x, z), (c, y, x), (x, y, z))
    return np.concatenate([points, middle]), np.concatenate([np.stack(part, axis=1) for part in parts])


def make_sheet(columns: int, rows: int) -> Mesh:
    """The unit square of the plane z = 0, facing +Z, with texture coordinates (x, y); its triangles face all ways."""
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    a = (j * (columns + 1) + i).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    even = ((i + j) % 2 == 0).ravel()[:, None]
    first = np.where(even, np.stack([a, b, c], 1), np.stack([b, d, a], 1))
    second = np.where(even, np.stack([c, d, a], 1), np.stack([d, b, c], 1))
    triangles = np.concatenate([first, second]).astype(np.int32)
    return Mesh(points, triangles, uv=points[triangles][:, :, :2].astype(np.float32))


def make_body(mesh: Mesh, **maps: np.ndarray) -> Body:
    """A body of one joint."""
    n = len(mesh.points)
    skeleton = Skeleton(("root",), np.array([-1], np.int32), np.eye(4)[None], np.array([[0.0, 0.1, 0.0]]))
    return Body(mesh, skeleton, np.zeros((n, 1), np.int32), np.ones((n, 1)), maps)


@pytest.fixture(scope="session")
def icosphere() -> Callable[..., Mesh]:
    return make_icosphere


@pytest.fixture(scope="session")
def sheet() -> Callable[..., Mesh]:
    return make_sheet


@pytest.fixture(scope="session")
def body_of() -> Callable[..., Body]:
    return make_body


@pytest.fixture(scope="session")
def ball() -> Body:
    """A sphere of 0.1 m whose upper half is scalp."""
    mesh = make_icosphere(4, 0.1)
    return make_body(mesh, scalp=(mesh.points[:, 1] > 0.0).astype(float))


@pytest.fixture
def threads() -> Iterator[Callable[[int], None]]:
    """Set the number of threads of numba, for this test."""
    before = numba.get_num_threads()
    yield numba.set_num_threads
    numba.set_num_threads(before)
