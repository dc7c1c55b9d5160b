"""Our own body: a mannequin's head, neck and shoulders, polygonised, rigged and painted from nothing."""

from collections.abc import Callable
from functools import partial

import numpy as np

from hairpipe.body.anatomy import BUST
from hairpipe.body.blended_shapes import evaluate, project
from hairpipe.body.scalp import Scalp, height_above, smooth_step
from hairpipe.body.unwrapping import Chart, unwrapped
from hairpipe.geometry.isosurface import extract_surface
from hairpipe.values import Body, Mesh, Skeleton


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
    points, triangles = polygonise()
    around = points - np.array(EARS)
    maps = {
        "scalp": height_above(HAIRLINE, around),
        "length": SHORTEST + (1.0 - SHORTEST) * height_above(LENGTHS, around),
    }
    uv = unwrapped(points, triangles, parts_of(points, triangles), CHARTS)
    mesh = Mesh(points, triangles, uv=uv.astype(np.float32))
    joints = np.tile(np.arange(len(JOINTS), dtype=np.int32), (len(points), 1))
    return Body(mesh, build_skeleton(), joints, blend_weights(points), maps)


def polygonise() -> tuple[np.ndarray, np.ndarray]:
    """Return points [m] and triangles of the surface: sampled, then drawn onto it and evened out."""
    right = graded_axis(SPACING_X) + 0.5 * SPACING_X[0][1]
    axes = (np.concatenate([-right[::-1], right]), graded_axis(SPACING_Y), graded_axis(SPACING_Z))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = evaluate(BUST, grid.reshape(-1, 3)).reshape(grid.shape[:3])
    points, triangles = extract_surface(values, axes)
    points = project(BUST, points, steps=2)
    return relax(points, triangles, partial(project, BUST), rounds=6), triangles


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


def blend_weights(points: np.ndarray) -> np.ndarray:
    """Return weights (n, 4) that pass from joint to joint up the neck; the cuts tilt so that the jaw is all head."""
    level = points[:, 1] + 0.48 * points[:, 2] - 4.0 * points[:, 0] ** 2
    above = [np.ones(len(points))]
    above += [smooth_step(level, low, high) for low, high in ((0.115, 0.185), (0.155, 0.225), (0.200, 0.255))]
    return -np.diff(np.stack([*above, np.zeros(len(points))], axis=1), axis=1)


def parts_of(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the chart of each triangle (m,): head, shoulders and base, cut at the neck and at the lower edge."""
    _, y, z = points[triangles].mean(axis=1).T
    return np.where(y + 0.48 * z > NECK, 0, np.where(y > EDGE, 1, 2))
