"""A solid torus of tetrahedra: Fig. 4a of Selle, Lentine, Fedkiw 2008."""

import numpy as np

from hairpipe.graphs.experiments.elastic.elastic_values import Solid


def build_torus(ring: float, tube: float, layers: int, around: int, height: float) -> Solid:
    """Sweep a disc along a ring about the Y axis and cut every prism into three tetrahedra.

    ring    radius of the ring [m]; tube  radius of the disc [m]
    layers  of triangles across the radius of the disc; around  prisms along the ring
    height  of the bottom of the tube above the ground [m]
    """
    disc, triangles = _disc(layers)
    angle = 2 * np.pi * np.arange(around)[:, None] / around
    radius = ring + tube * disc[:, 0]
    up = np.broadcast_to(height + tube * (1 + disc[:, 1]), (around, len(disc)))
    points = np.stack([radius * np.sin(angle), up, radius * np.cos(angle)], axis=2).reshape(-1, 3)
    # Sorted corners give the two prisms next to a wall the same diagonal.
    i, j, k = np.sort(triangles, axis=1).T
    here = np.arange(around) * len(disc)
    there = np.roll(np.arange(around), -1) * len(disc)
    corners = [np.add.outer(at, c) for at in (here, there) for c in (i, j, k)]
    cuts = ((0, 1, 2, 5), (0, 1, 4, 5), (0, 3, 4, 5))
    tetrahedra = np.stack([np.stack([corners[c] for c in cut], axis=-1) for cut in cuts], axis=2).reshape(-1, 4)
    return Solid(points, _upright(points, tetrahedra).astype(np.int32))


def _disc(layers: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit disc of rings of 6, 12, ... points about its centre: points (n, 2) and triangles (6 layers^2, 3)."""
    points = [np.zeros((1, 2))]
    first = [0, 1]
    for r in range(1, layers + 1):
        angle = 2 * np.pi * np.arange(6 * r) / (6 * r)
        points.append(r / layers * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        first.append(first[-1] + 6 * r)
    triangles = []
    for r in range(1, layers + 1):
        inner = max(6 * (r - 1), 1)
        outer = 6 * r
        for i in range(outer):
            sextant, step = divmod(i, r)
            a = first[r] + i
            b = first[r] + (i + 1) % outer
            c = first[r - 1] + (sextant * (r - 1) + step) % inner
            triangles.append((a, b, c))
            if step:
                triangles.append((a, c, first[r - 1] + (sextant * (r - 1) + step - 1) % inner))
    return np.concatenate(points), np.array(triangles)


def _upright(points: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """Exchange the last two particles where the volume is negative."""
    a, b, c, d = (points[tetrahedra[:, i]] for i in range(4))
    wrong = np.sum(np.cross(c - a, d - a) * (b - a), axis=1) < 0
    return np.where(wrong[:, None], tetrahedra[:, [0, 1, 3, 2]], tetrahedra)
