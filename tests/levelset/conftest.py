"""Bodies whose distance and velocity are known in closed form."""

from collections.abc import Callable

import numpy as np
import pytest

from hairpipe.data import Mesh


def make_sphere(radius: float = 1.0, centre=(0.0, 0.0, 0.0), level: int = 4) -> Mesh:
    """An octahedron, every triangle cut into 4^level, blown up to a sphere."""
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    triangles = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(level):
        sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, where = np.unique(sides, axis=0, return_inverse=True)
        (a, b, c), (x, y, z) = triangles.T, len(points) + where.reshape(-1, 3).T
        middles = points[edges].sum(axis=1)
        points = np.concatenate([points, middles / np.linalg.norm(middles, axis=1, keepdims=True)])
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))])
    return Mesh(points * radius + np.array(centre), triangles.astype(np.int32))


def make_box(low=(-0.5, -0.5, -0.5), high=(0.5, 0.5, 0.5)) -> Mesh:
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(np.array(low) + points * (np.array(high) - np.array(low)), np.array(triangles, np.int32))


def make_torus(radius: float, tube: float, count: int = 64) -> Mesh:
    u, v = (a.ravel() for a in np.meshgrid(*[np.arange(count) * (2 * np.pi / count)] * 2, indexing="ij"))
    ring = radius + tube * np.cos(v)
    points = np.stack([ring * np.cos(u), tube * np.sin(v), ring * np.sin(u)], axis=1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    a, b = i * count + j, (i + 1) % count * count + j
    c, d = (i + 1) % count * count + (j + 1) % count, i * count + (j + 1) % count
    return Mesh(points, np.concatenate([np.stack([a, d, c], 1), np.stack([a, c, b], 1)]).astype(np.int32))


def merge(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.points for mesh in meshes]), np.concatenate(triangles).astype(np.int32))


@pytest.fixture(scope="session")
def sphere() -> Callable[..., Mesh]:
    return make_sphere


@pytest.fixture(scope="session")
def box() -> Callable[..., Mesh]:
    return make_box


@pytest.fixture(scope="session")
def torus() -> Callable[..., Mesh]:
    return make_torus


@pytest.fixture(scope="session")
def together() -> Callable[..., Mesh]:
    return merge


@pytest.fixture(scope="session")
def positions() -> Callable[..., np.ndarray]:
    """Where the samples of a level set's bricks lie, (B, 9, 9, 9, 3)."""

    def found(surface):
        places = np.argwhere(surface.bricks >= 0)
        order = np.argsort(surface.bricks[tuple(places.T)])
        inside = np.stack(np.meshgrid(*[np.arange(9)] * 3, indexing="ij"), axis=-1)
        return surface.origin + surface.voxel * (8 * places[order][:, None, None, None] + inside)

    return found
