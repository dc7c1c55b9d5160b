"""Texture coordinates without overlap: each part of a surface is flattened onto a disc.

A part with one boundary is embedded by weighted averages: the boundary lies on a circle, and every other vertex is a
positively weighted average of its neighbours, so that no triangle is folded (Tutte 1963). Weights are the mean values
of Floater 2003, divided by the stretch of each neighbour, repeatedly (Yoshizawa, Belyaev, Seidel 2004): triangles of
equal area have nearly equal areas in the picture.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import spsolve

ROUNDS = 3
"""Number of corrections by stretch."""


class Chart(NamedTuple):
    """Disc of the unit square that a part fills."""

    centre: tuple[float, float]
    radius: float


def unwrapped(points: np.ndarray, triangles: np.ndarray, parts: np.ndarray, charts: tuple[Chart, ...]) -> np.ndarray:
    """Return texture coordinates (m, 3, 2) of the corners of triangles (m, 3), each part in its chart. Pure.

    A chart shows its part as seen from outside, with the front, the largest z of its boundary, below. Holes within a
    part stay empty in its chart.

    points  (n, 3)
    parts   number of the chart of each triangle, (m,); every part is connected, with a boundary
    """
    uv = np.empty((*triangles.shape, 2))
    for number, chart in enumerate(charts):
        mine = np.flatnonzero(parts == number)
        used, local = np.unique(triangles[mine], return_inverse=True)
        local = local.reshape(-1, 3)
        uv[mine] = chart.centre + chart.radius * flattened(points[used], local)[local]
    return uv


def flattened(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return places (n, 2) of points (n, 3) in the unit disc, whose circle is the longest boundary."""
    count = len(points)
    loops = boundaries(triangles)
    lengths = [np.linalg.norm(points[loop] - np.roll(points[loop], 1, axis=0), axis=1).sum() for loop in loops]
    rim, *holes = [loops[k] for k in sorted(range(len(loops)), key=lambda k: -lengths[k])]
    rim = np.roll(rim, -np.argmax(points[rim, 2]))
    for hole in holes:  # closed by a fan about its middle
        fan = np.stack([np.full(len(hole), len(points)), np.roll(hole, -1), hole], axis=1)
        triangles = np.concatenate([triangles, fan])
        points = np.concatenate([points, [points[hole].mean(axis=0)]])
    steps = np.linalg.norm(points[np.roll(rim, -1)] - points[rim], axis=1)
    angles = 2.0 * np.pi * (np.cumsum(steps) - steps) / steps.sum() - 0.5 * np.pi
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    stretch = np.ones(len(points))
    places = np.zeros((len(points), 2))
    for _ in range(1 + ROUNDS):
        places = embedded(points, triangles, rim, circle, stretch)
        stretch *= stretch_of(points, places, triangles)
    return places[:count]


def boundaries(triangles: np.ndarray) -> list[np.ndarray]:
    """List the boundary loops of a surface, each as its vertices in the direction of its triangles."""
    edges = np.concatenate([triangles[:, (k, (k + 1) % 3)] for k in range(3)])
    known = {(int(a), int(b)) for a, b in edges}
    following = {a: b for a, b in sorted(known) if (b, a) not in known}
    loops = []
    while following:
        first, at = following.popitem()
        loop = [first]
        while at != first:
            loop.append(at)
            at = following.pop(at)
        loops.append(np.array(loop))
    return loops


def embedded(
    points: np.ndarray, triangles: np.ndarray, rim: np.ndarray, circle: np.ndarray, stretch: np.ndarray
) -> np.ndarray:
    """Return places (n, 2), those of `rim` given, each other one the average of its neighbours."""
    rows, columns, values = [], [], []
    for k in range(3):
        here, ahead, behind = (triangles[:, (k + j) % 3] for j in range(3))
        to_ahead, to_behind = points[ahead] - points[here], points[behind] - points[here]
        spans = np.linalg.norm(to_ahead, axis=1), np.linalg.norm(to_behind, axis=1)
        sine = np.linalg.norm(np.cross(to_ahead, to_behind), axis=1)
        tangent = sine / (spans[0] * spans[1] + np.einsum("ij,ij->i", to_ahead, to_behind))  # of half the angle
        for other, span in zip((ahead, behind), spans, strict=True):
            rows.append(here)
            columns.append(other)
            values.append(tangent / (span * stretch[other]))
    count = len(points)
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    weights = coo_matrix(entries, (count, count)).tocsr()
    weights = weights.multiply(1.0 / weights.sum(axis=1)).tocsr()
    free = np.setdiff1d(np.arange(count), rim)
    places = np.zeros((count, 2))
    places[rim] = circle
    system = identity(len(free), format="csc") - weights[free][:, free]
    places[free] = spsolve(system.tocsc(), weights[free][:, rim] @ circle)
    return places


def stretch_of(points: np.ndarray, places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the stretch of each vertex (n,): root mean square of the growth of lengths from picture to surface."""
    a, b, c = (places[triangles[:, k]] for k in range(3))
    p, q, r = (points[triangles[:, k]] for k in range(3))
    double = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    along_u = p * (b - c)[:, 1:] + q * (c - a)[:, 1:] + r * (a - b)[:, 1:]
    along_v = p * (c - b)[:, :1] + q * (a - c)[:, :1] + r * (b - a)[:, :1]
    square = (np.square(along_u).sum(axis=1) + np.square(along_v).sum(axis=1)) / (2.0 * np.square(double))
    area = 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1)
    sums = np.zeros((2, len(points)))
    for k in range(3):
        np.add.at(sums[0], triangles[:, k], area * square)
        np.add.at(sums[1], triangles[:, k], area)
    return np.sqrt(sums[0] / sums[1])
