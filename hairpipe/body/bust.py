"""Our own body: a mannequin's head, neck and shoulders, polygonised, rigged and painted from nothing.

Each part of its surface is flattened onto a disc of the texture, without overlap: the boundary lies on a circle, and
every other vertex is a positively weighted average of its neighbours, so that no triangle is folded (Tutte 1963).
Weights are the mean values of Floater 2003, divided by the stretch of each neighbour, repeatedly (Yoshizawa, Belyaev,
Seidel 2004): triangles of equal area have nearly equal areas in the picture.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import spsolve

from hairpipe.body.anatomy import BUST
from hairpipe.body.blended_shapes import evaluate, project
from hairpipe.body.scalp import Scalp, height_above, smooth_step
from hairpipe.geometry.isosurface import extract_surface
from hairpipe.values import Body, Mesh, Skeleton

ROUNDS = 3  # number of corrections by stretch


class Chart(NamedTuple):
    """Disc of the unit square that a part fills."""

    centre: tuple[float, float]
    radius: float


def unwrapped(points: np.ndarray, triangles: np.ndarray, parts: np.ndarray, charts: tuple[Chart, ...]) -> np.ndarray:
    """Return texture coordinates (m, 3, 2) of the corners of triangles (m, 3), each part in its chart. Pure.

    A chart shows its part, which is connected, as seen from outside, with the front, the largest z of its boundary,
    below. Holes within a part stay empty in its chart.
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


def relax(
    points: np.ndarray, triangles: np.ndarray, draw: Callable[[np.ndarray], np.ndarray], rounds: int
) -> np.ndarray:
    """Slide the vertices of a closed surface (n, 3) to the mean of their neighbours, and `draw` them back; pure."""
    tail = triangles.ravel()
    head = triangles[:, (1, 2, 0)].ravel()
    neighbours = np.bincount(tail, minlength=len(points))[:, None]
    for _ in range(rounds):
        total = np.stack([np.bincount(tail, points[head, axis], len(points)) for axis in range(3)], axis=1)
        shift = total / neighbours - points
        # Unlike `vertex_normals`, first corners are added, then second, then third ones: the last bits of the bust, and
        # so of all hair that was grown on it, depend on the order.
        a, b, c = (points[triangles[:, corner]] for corner in range(3))
        doubled_area = np.cross(b - a, c - a)
        normals = np.zeros_like(points)
        for corner in range(3):
            for axis in range(3):
                normals[:, axis] += np.bincount(triangles[:, corner], doubled_area[:, axis], len(points))
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        shift -= np.einsum("ij,ij->i", shift, normals)[:, None] * normals
        points = draw(points + 0.5 * shift)
    return points


# Spacing of the samples [m] at coordinates between which it changes linearly: fine at face and ears, coarse below.
SPACING_X = ((0.0, 0.0050), (0.06, 0.0054), (0.09, 0.0068), (0.11, 0.013), (0.215, 0.016))
SPACING_Y = (
    *((-0.02, 0.009), (0.02, 0.011), (0.05, 0.016), (0.17, 0.016)),
    *((0.24, 0.0050), (0.26, 0.0036), (0.28, 0.0036), (0.31, 0.0052), (0.36, 0.0062), (0.40, 0.0072), (0.46, 0.0088)),
)
SPACING_Z = ((-0.16, 0.011), (-0.1, 0.0095), (0.0, 0.0064), (0.06, 0.0055), (0.12, 0.005))

JOINTS = {
    "chest": (0.0, 0.060, -0.045),
    "neck": (0.0, 0.165, -0.048),
    "neck1": (0.0, 0.222, -0.038),
    "head": (0.0, 0.280, -0.018),
}
CROWN = (0.0, 0.450, -0.015)
EARS = (0.0, 0.330, 0.0)  # the point between the ear canals

HAIRLINE = Scalp(front=42.0, temple=42.0, sideburn=12.0, ear=29.0, behind=-26.0, nape=-37.0, edge=7.0)
LENGTHS = Scalp(front=62.0, temple=62.0, sideburn=55.0, ear=55.0, behind=10.0, nape=-5.0, edge=50.0)
CHARTS = (Chart((0.33, 0.67), 0.32), Chart((0.775, 0.225), 0.215), Chart((0.885, 0.885), 0.1))
"""Places in the texture of the head, seen from the crown, of the shoulders, seen from above, and of the base."""
NECK, EDGE = 0.19, 0.02  # heights of the cuts between them; that of the neck tilts as the weights do
SHORTEST = 0.6  # length of the hair at the hairline, as a share of that at the crown


def build_bust() -> Body:
    """Return the bust [m]: a closed mesh, four joints, weights, uv without overlap, maps "scalp", "length". Pure."""
    right = graded_axis(SPACING_X) + 0.5 * SPACING_X[0][1]
    axes = (np.concatenate([-right[::-1], right]), graded_axis(SPACING_Y), graded_axis(SPACING_Z))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = evaluate(BUST, grid.reshape(-1, 3)).reshape(grid.shape[:3])
    points, triangles = extract_surface(values, axes)
    points = project(BUST, points, steps=2)
    points = relax(points, triangles, partial(project, BUST), rounds=6)
    around = points - np.array(EARS)
    maps = {
        "scalp": height_above(HAIRLINE, around),
        "length": SHORTEST + (1.0 - SHORTEST) * height_above(LENGTHS, around),
    }
    uv = unwrapped(points, triangles, parts_of(points, triangles), CHARTS)
    mesh = Mesh(points, triangles, uv=uv.astype(np.float32))
    joints = np.tile(np.arange(len(JOINTS), dtype=np.int32), (len(points), 1))
    # Weights pass from joint to joint up the neck; the cuts tilt so that the jaw is all head.
    level = points[:, 1] + 0.48 * points[:, 2] - 4.0 * points[:, 0] ** 2
    above = [np.ones(len(points))]
    above += [smooth_step(level, low, high) for low, high in ((0.115, 0.185), (0.155, 0.225), (0.200, 0.255))]
    weights = -np.diff(np.stack([*above, np.zeros(len(points))], axis=1), axis=1)
    return Body(mesh, build_skeleton(), joints, weights, maps)


def graded_axis(spacing: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Return coordinates [m] from the first to beyond the last one of `spacing`, as far apart as it states."""
    places, steps = np.array(spacing).T
    coordinates = [places[0]]
    while coordinates[-1] < places[-1]:
        coordinates.append(coordinates[-1] + np.interp(coordinates[-1], places, steps))
    return np.array(coordinates)


def build_skeleton() -> Skeleton:
    """Return the chain chest, neck, neck1, head; every joint's frame is that of the world."""
    heads = np.array(list(JOINTS.values()))
    rest = np.tile(np.eye(4), (len(JOINTS), 1, 1))
    rest[:, :3, 3] = heads
    tips = np.concatenate([heads[1:], [CROWN]])
    return Skeleton(tuple(JOINTS), np.arange(-1, len(JOINTS) - 1, dtype=np.int32), rest, tips)


def parts_of(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the chart of each triangle (m,): head, shoulders and base, cut at the neck and at the lower edge."""
    _, y, z = points[triangles].mean(axis=1).T
    return np.where(y + 0.48 * z > NECK, 0, np.where(y > EDGE, 1, 2))
