"""Visible points of the body: the closest triangle at every pixel."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.render.camera import NEAR, Camera
from hairpipe.values import Mesh
from hairpipe.values.triangles import vertex_normals

UNSEEN = -1
Place = tuple[float, float]  # column and row on the film [pixels]


@njit(cache=True, nogil=True)
def rasterise(
    film: np.ndarray, triangles: np.ndarray, closeness: np.ndarray, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Find the closest triangle, (m, 3), over every pixel centre of a film; of equals the first in order.

    film       column and row of the vertices [pixels], (n, 2) float64
    closeness  greater is closer; linear on the film, as 1/depth is in perspective, (n,); omitted with vertices <= 0

    Returns its index, or UNSEEN, (height, width) int32, and its closeness, or 0, (height, width) float64.
    """
    seen = np.full((height, width), UNSEEN, np.int32)
    best = np.zeros((height, width))
    for m in range(len(triangles)):
        a, b, c = triangles[m]
        ax, ay, bx, by, cx, cy = film[a, 0], film[a, 1], film[b, 0], film[b, 1], film[c, 0], film[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)  # Signed, so that weights are positive inside either way.
        if area == 0.0 or min(closeness[a], closeness[b], closeness[c]) <= 0.0:
            continue
        for i in range(first_centre(min(ay, by, cy), height), first_centre(max(ay, by, cy), height)):
            for j in range(first_centre(min(ax, bx, cx), width), first_centre(max(ax, bx, cx), width)):
                u, v, w = weights((ax, ay), (bx, by), (cx, cy), area, j + 0.5, i + 0.5)
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                close = u * closeness[a] + v * closeness[b] + w * closeness[c]
                if close > best[i, j]:  # Not >=: of equals the first in order stays.
                    best[i, j] = close
                    seen[i, j] = m
    return seen, best


@njit(cache=True, nogil=True, inline="always")
def weights(a: Place, b: Place, c: Place, area: float, x: float, y: float) -> tuple[float, float, float]:
    """Return the barycentric coordinates of the film point (x, y) in the triangle abc of twice this signed area."""
    u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
    v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
    return u, v, 1.0 - u - v


@njit(cache=True, nogil=True, inline="always")
def first_centre(x: float, size: int) -> int:
    """Return the index of the first pixel whose centre is not before x, held within 0..size, for x of any magnitude."""
    return math.ceil(min(max(x, 0.0), size + 0.5) - 0.5)


@dataclass(frozen=True)
class Surface:
    """Visible points of the body, one for every pixel of it."""

    rows: np.ndarray  # of the pixels, (n,) int64
    columns: np.ndarray  # of the pixels, (n,) int64
    points: np.ndarray  # seen [m], (n, 3) float64
    normals: np.ndarray  # there, interpolated between the vertices and turned to the eye, unit vectors, (n, 3)
    depth: np.ndarray  # of every pixel of the film along the view axis [m], infinite without body, (height, width)


class Sight(NamedTuple):
    """Visible triangle of a body at every pixel."""

    rows: np.ndarray  # of the pixels with a triangle, (n,) int64
    columns: np.ndarray  # of these, (n,) int64
    depth: np.ndarray  # of every pixel of the film along the view axis [m], infinite without body, (height, width)
    seen: np.ndarray  # triangle, (height, width) int32
    places: np.ndarray  # of the vertices on the film, as `Camera.project` gives them, (v, 3)
    closeness: np.ndarray  # of the vertices, 0 where they are behind the eye, (v,)


def look_at_body(body: Mesh, camera: Camera) -> Sight:
    """Find the triangles at the pixel centres, without those that reach behind the eye."""
    places = camera.project(body.points)
    closeness = np.where(places[:, 2] > NEAR, 1.0 / np.maximum(places[:, 2], NEAR), 0.0)
    seen, close = rasterise(np.ascontiguousarray(places[:, :2]), body.triangles, closeness, camera.height, camera.width)
    rows, columns = map(np.ascontiguousarray, np.nonzero(seen != UNSEEN))
    depth = np.full(seen.shape, np.inf)
    depth[rows, columns] = 1.0 / close[rows, columns]
    return Sight(rows, columns, depth, seen, places, closeness)


def seen_vertices(sight: Sight, triangles: np.ndarray) -> np.ndarray:
    """List the vertices of visible triangles, ascending."""
    faces = np.zeros(len(triangles), bool)
    corners = np.zeros(len(sight.places), bool)
    faces[sight.seen[sight.rows, sight.columns]] = True
    corners[triangles[faces]] = True
    return np.flatnonzero(corners)


@njit(cache=True, nogil=True)
def at_pixels(sight: Sight, triangles: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Interpolate values of vertices, (v, 3), at the pixels of the body, perspective-correct, (n, 3) float64."""
    taken = np.empty((len(sight.rows), 3))
    film, closeness = sight.places, sight.closeness
    for p in range(len(taken)):
        i, j = sight.rows[p], sight.columns[p]
        m = sight.seen[i, j]
        a, b, c = triangles[m, 0], triangles[m, 1], triangles[m, 2]
        ax, ay, bx, by, cx, cy = film[a, 0], film[a, 1], film[b, 0], film[b, 1], film[c, 0], film[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        u, v, w = weights((ax, ay), (bx, by), (cx, cy), area, j + 0.5, i + 0.5)
        u, v, w = u * closeness[a], v * closeness[b], w * closeness[c]  # Over depth, values are linear on the film.
        for d in range(3):
            taken[p, d] = (u * values[a, d] + v * values[b, d] + w * values[c, d]) / (u + v + w)
    return taken


def see_body(body: Mesh, camera: Camera, moved: Mesh | None = None) -> Surface:
    """Find the body's points at the pixel centres; `moved`, if any, determines visibility."""
    sight = look_at_body(body if moved is None else moved, camera)
    points, normals = (at_pixels(sight, body.triangles, some) for some in (body.points, vertex_normals(body)))
    # not by the direction of each: near an outline, normals of a front face may point away from the eye
    (ax, ay), (bx, by), (cx, cy) = sight.places[body.triangles, :2].transpose(1, 2, 0)
    sides = np.where((bx - ax) * (cy - ay) > (by - ay) * (cx - ax), -1.0, 1.0)[sight.seen[sight.rows, sight.columns]]
    normals *= (sides / np.maximum(np.linalg.norm(normals, axis=1), 1e-12))[:, None]
    return Surface(sight.rows, sight.columns, points, normals, sight.depth)


@njit(cache=True, nogil=True)
def turn_to(eye: np.ndarray, points: np.ndarray, normals: np.ndarray) -> None:
    """Normalise normals and flip those away from the eye, in place."""
    for p in range(len(points)):
        length, ahead = 0.0, 0.0
        for d in range(3):
            length += normals[p, d] ** 2
            ahead += normals[p, d] * (eye[d] - points[p, d])
        scale = (1.0 if ahead >= 0.0 else -1.0) / max(np.sqrt(length), 1e-12)
        for d in range(3):
            normals[p, d] *= scale
