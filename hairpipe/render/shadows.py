"""Deep opacity maps: the optical depth of hair and body between a lamp and a point.

A cube of cells surrounds the scene with one edge along the light. Every hair segment adds the area it shows to the
light, over the area of a cell; summed along the light this is the number of hairs that a ray crosses on average: the
deep opacity map of Yuksel and Keyser 2008 with layers of equal thickness, itself a cheap form of the deep shadow map of
Lokovic and Veach 2000. Behind the body the depth grows to SOLID.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.trilinear import sample, splat, voxel_at
from hairpipe.render.lights import Light
from hairpipe.render.surface import rasterise
from hairpipe.values import Mesh

CELLS, FEW = 160, 128
"""Along an edge of the cube, of a lamp as bright as FAINT, and of others: there, so few cells change a picture no more
than do other places of as many as the bright lamps have."""
FAINT = 1.0  # largest component of the colour of a lamp below which its cube has FEW cells
SOLID = 15.0
"""Optical depth of the body, in hairs: nearly opaque, with a soft edge of the shadow."""
FINE = 2
"""Rays across a cell that are cast to the body."""
BIAS = 1.5
"""Distance of the shadow behind the body's surface, so that the body does not shade its own lit side [cells]."""


class Shadow(NamedTuple):
    """Optical depth in front of the cells of a cube, as seen from a lamp."""

    light: Light
    to_cells: np.ndarray  # motion of world points to places in the cube [cells], the third away from the lamp, (3, 4)
    cell: float  # edge of a cell [m]
    depth: np.ndarray  # at the centres of the cells, (n, n, n) float32

    def between(self, points: np.ndarray) -> np.ndarray:
        """Optical depths between the lamp and world points (n, 3), (n,) float64."""
        return look_up_all(self.depth, self.to_cells, points)


def cast_shadow(
    light: Light,
    centre: np.ndarray,
    radius: float,
    points: np.ndarray,
    offsets: np.ndarray,
    width: float | np.ndarray,
    body: Mesh,
) -> Shadow:
    """Cast the shadow of hair of a width, or of widths at points [m], and of a body away from a lamp.

    centre, radius  of the scene [m]: half an edge of the cube
    """
    cells = CELLS if light.colour.max() >= FAINT else FEW
    cell, to_cells = cells_of(light, centre, radius, cells)
    depth = np.zeros((cells, cells, cells), np.float32)
    scatter(depth, apply(to_cells, points), offsets, np.broadcast_to(width, len(points)) / cell)
    accumulate(depth, front(apply(to_cells, body.points), body.triangles, FINE, cells))
    return Shadow(light, to_cells, cell, depth)


def cells_of(light: Light, centre: np.ndarray, radius: float, cells: int) -> tuple[float, np.ndarray]:
    """Return the edge of a cell of the cube around a scene [m], and the motion of world points into it, (3, 4)."""
    cell = 2.0 * radius / cells
    axes = np.stack([*axes_across(light), -light.towards]) / cell  # two across the light, one away from the lamp
    return cell, np.column_stack([axes, cells / 2 - axes @ centre])


def axes_across(light: Light) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors across the light of a lamp, (3,)."""
    towards = light.towards
    aside = np.cross(towards, [0.0, 1.0, 0.0] if abs(towards[1]) < 0.9 else [1.0, 0.0, 0.0])
    aside /= np.linalg.norm(aside)
    return aside, np.cross(aside, -towards)


def apply(to_cells: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return places of world points (n, 3) in the cube [cells], (n, 3)."""
    return points @ to_cells[:, :3].T + to_cells[:, 3]


def front(places: np.ndarray, triangles: np.ndarray, fine: int, cells: int) -> np.ndarray:
    """Return the depth of the body along the rays [cells], infinite outside, (fine*cells, fine*cells)."""
    far = places[:, 2].max(initial=0.0) + 1.0
    _, close = rasterise(fine * places[:, 1::-1], triangles, far - places[:, 2], fine * cells, fine * cells)
    return np.where(close > 0.0, far - close, np.inf)


@njit(cache=True, nogil=True)
def scatter(depth: np.ndarray, places: np.ndarray, offsets: np.ndarray, widths: np.ndarray) -> None:
    """Add the projected area of every segment [cell areas] to the cells, in place; places (p, 3), widths in cells."""
    for s in range(len(offsets) - 1):
        for i in range(offsets[s], offsets[s + 1] - 1):
            x, y, z = places[i, 0], places[i, 1], places[i, 2]
            dx, dy, dz = places[i + 1, 0] - x, places[i + 1, 1] - y, places[i + 1, 2] - z
            area = 0.5 * (widths[i] + widths[i + 1]) * math.hypot(dx, dy)
            add(depth, x + 0.25 * dx, y + 0.25 * dy, z + 0.25 * dz, 0.5 * area)
            add(depth, x + 0.75 * dx, y + 0.75 * dy, z + 0.75 * dz, 0.5 * area)


@njit(cache=True, nogil=True)
def add(depth: np.ndarray, x: float, y: float, z: float, area: float) -> None:
    """Share an area among the eight cells around a place, in place; a place outside the cube is ignored."""
    top = len(depth) - 1.5
    if not (0.5 <= x < top and 0.5 <= y < top and 0.5 <= z < top):
        return
    splat(depth, voxel_at(depth, x - 0.5, y - 0.5, z - 0.5), area)


@njit(cache=True, nogil=True)
def accumulate(depth: np.ndarray, solid: np.ndarray) -> None:
    """Sum the cells along the light, each to its centre, and fill the cells behind the body, in place."""
    cells = len(depth)
    for i in range(cells):
        for j in range(cells):
            before = 0.0  # Along the light each ray is a running sum; rays are independent.
            nearest = np.inf
            for n in range(FINE * FINE):
                nearest = min(nearest, solid[FINE * i + n // FINE, FINE * j + n % FINE])
            for k in range(cells):
                behind = 0.0
                if k + 0.5 > nearest + BIAS:
                    for n in range(FINE * FINE):
                        start = solid[FINE * i + n // FINE, FINE * j + n % FINE]
                        behind += min(max(k + 0.5 - start - BIAS, 0.0), 1.0) / FINE**2
                own = depth[i, j, k]
                if own + before + behind > 0.0:  # empty cells are not written
                    depth[i, j, k] = before + 0.5 * own + SOLID * behind  # Half of the cell's own hair is in front.
                    before += own


@njit(cache=True, nogil=True, inline="always")
def look_up(depth: np.ndarray, to_cells: np.ndarray, px: float, py: float, pz: float) -> float:
    """Return the optical depth at a world point, between the centres of the cells; none outside the cube."""
    x = to_cells[0, 0] * px + to_cells[0, 1] * py + to_cells[0, 2] * pz + to_cells[0, 3] - 0.5
    y = to_cells[1, 0] * px + to_cells[1, 1] * py + to_cells[1, 2] * pz + to_cells[1, 3] - 0.5
    z = to_cells[2, 0] * px + to_cells[2, 1] * py + to_cells[2, 2] * pz + to_cells[2, 3] - 0.5
    last = len(depth) - 1.0
    if not (0.0 <= x < last and 0.0 <= y < last):
        return 0.0
    return sample(depth, voxel_at(depth, x, y, min(max(z, 0.0), last)))


@njit(cache=True, nogil=True)
def look_up_all(depth: np.ndarray, to_cells: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return optical depths at world points (n, 3), (n,) float64."""
    taken = np.empty(len(points))
    for p in range(len(points)):
        taken[p] = look_up(depth, to_cells, points[p, 0], points[p, 1], points[p, 2])
    return taken
