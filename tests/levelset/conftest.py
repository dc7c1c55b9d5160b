"""Bodies whose distance and velocity are known in closed form."""

import numpy as np

from hairpipe.values import Mesh


def torus(radius: float, tube: float, count: int = 64) -> Mesh:
    u, v = (a.ravel() for a in np.meshgrid(*[np.arange(count) * (2 * np.pi / count)] * 2, indexing="ij"))
    ring = radius + tube * np.cos(v)
    points = np.stack([ring * np.cos(u), tube * np.sin(v), ring * np.sin(u)], axis=1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    a, b = i * count + j, (i + 1) % count * count + j
    c, d = (i + 1) % count * count + (j + 1) % count, i * count + (j + 1) % count
    return Mesh(points, np.concatenate([np.stack([a, d, c], 1), np.stack([a, c, b], 1)]).astype(np.int32))


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.points for mesh in meshes]), np.concatenate(triangles).astype(np.int32))


def positions(surface):
    """Where the samples of a level set's bricks lie, (B, 9, 9, 9, 3)."""
    places = np.argwhere(surface.bricks >= 0)
    order = np.argsort(surface.bricks[tuple(places.T)])
    inside = np.stack(np.meshgrid(*[np.arange(9)] * 3, indexing="ij"), axis=-1)
    return surface.origin + surface.voxel * (8 * places[order][:, None, None, None] + inside)
