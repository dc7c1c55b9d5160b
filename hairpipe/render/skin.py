"""Shading of the body: diffuse, red at the terminator, a faint highlight, and hair's colour between drawn strands."""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from hairpipe.render.lights import Light, Shade
from hairpipe.render.shadows import CELLS, FAINT, add, axes_across, look_up_all
from hairpipe.render.surface import Surface

CLAY = np.array([0.25, 0.21, 0.19])
"""Colour of the body, linear."""
WRAP = np.array([0.38, 0.22, 0.15])  # width of wrapped diffuse light: largest for red, as in skin
IRRADIANCE = math.pi * (1.0 + WRAP.mean()) * 4.0 / 6.0
"""Of a surface that faces a lamp of colour 1, where light is physical and a sphere as bright as the body is here.

Here the mean of ((n.l + w)/(1 + w))^2 over all normals is (1 + w)/6, there that of n.l where positive is 1/4.
"""
SHEEN = 0.25  # strength of the highlight
AMBIENT = 0.05
"""Light that comes from everywhere."""
DENSITY = 0.2
"""Attenuation of light by the hair before the body, per hair."""
GRAZING = 0.3  # cosine to the lamp below which cells are too coarse for self-shadowing: light fades to zero
LIFT = 1.5  # distance from the surface at which the shadow is sampled [cells]
PENUMBRA = 0.01
"""Radius of the disc over which the shadow of a bright lamp is averaged, for a soft edge without steps of cells [m]."""
SAMPLES = 8
"""Places on that disc."""


def shade_skin(surface: Surface, colours: np.ndarray, eye: np.ndarray, shadows: Sequence[Shade]) -> np.ndarray:
    """Return the light from visible points of the body to the eye, for their linear colours, (n, 3) float64."""
    shed = AMBIENT * colours
    for shadow in shadows:
        between = soft_depth(shadow, surface.points + LIFT * shadow.cell * surface.normals)
        add_light(shed, surface.points, surface.normals, colours, eye, shadow.light, between)
    return shed


def soft_depth(shadow: Shade, points: np.ndarray) -> np.ndarray:
    """Return optical depths whose light is the mean over a disc across the light, (n,) float64; points (n, 3) [m]."""
    light = shadow.light
    if light.colour.max() < FAINT:
        return shadow.between(points)
    aside, across = axes_across(light)
    through = np.zeros(len(points))
    for n in range(SAMPLES):  # a spiral of even density
        radius = PENUMBRA * math.sqrt((n + 0.5) / SAMPLES)
        angle = n * math.pi * (3.0 - math.sqrt(5.0))
        at = points + radius * (math.cos(angle) * aside + math.sin(angle) * across)
        through += np.exp(-DENSITY * shadow.between(at))
    return -np.log(through / SAMPLES) / DENSITY


@njit(cache=True, nogil=True)
def add_light(
    shed: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    colours: np.ndarray,
    eye: np.ndarray,
    light: Light,
    between: np.ndarray,
) -> None:
    """Add the light of one lamp that the points (n, 3) scatter to the eye, into `shed` (n, 3).

    between  optical depth between them and the lamp, (n,)

    Diffuse ((n.l + w)/(1 + w))^2 where positive, with a width w for every colour; specular (n.h)^16, h halfway between
    lamp and eye (Blinn 1977); both in the colour of the point.
    """
    lx, ly, lz = light.towards
    for i in range(len(shed)):
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        facing = nx * lx + ny * ly + nz * lz
        if facing <= -WRAP[0]:  # Red has the largest width.
            continue
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        ex, ey, ez = eye[0] - x, eye[1] - y, eye[2] - z
        away = math.sqrt(ex * ex + ey * ey + ez * ez)
        hx, hy, hz = ex / away + lx, ey / away + ly, ez / away + lz
        half = (nx * hx + ny * hy + nz * hz) / math.sqrt(hx * hx + hy * hy + hz * hz + 1e-12)
        sheen = SHEEN * max(0.0, half) ** 16 * min(1.0, max(0.0, 4.0 * facing))
        sure = min(1.0, max(0.0, facing / GRAZING))
        through = math.exp(-DENSITY * sure * between[i])
        for c in range(3):
            wrapped = max(0.0, (facing + WRAP[c]) / (1.0 + WRAP[c]))
            shed[i, c] += light.colour[c] * through * colours[i, c] * (wrapped * wrapped + sheen)


REACH = 0.012  # edge of the cells in which roots are counted: the softness of the hairline [m]
NEIGHBOURS = 4


def hair_share(points: np.ndarray, roots: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the density of roots on points of the skin (n, 3) over the usual one, at most 1, (n,) float64.

    Few strands do not cover the skin: in cells of REACH each root would be a spot. Cells grow with the distance of
    roots, and the share falls with their area. Axes are those of the cells, rows of a rotation.
    """
    edge = max(REACH, spacing(roots))
    shift = CELLS / 2 - axes @ roots.mean(axis=0) / edge
    to_cells = np.column_stack([axes / edge, shift])
    counts = np.zeros((CELLS, CELLS, CELLS), np.float32)
    count(counts, roots @ to_cells[:, :3].T + shift)
    usual = np.median(look_up_all(counts, to_cells, roots))
    return (REACH / edge) ** 2 * np.clip(look_up_all(counts, to_cells, points) / max(usual, 1e-6), 0.0, 1.0)


def spacing(roots: np.ndarray) -> float:
    """Return the edge of the square of skin per root [m]; infinity for a single root; roots (S, 3).

    The disc around a root that reaches its k-th neighbour has the area of k such squares.
    """
    from scipy.spatial import KDTree  # here: a node that names this function is read without it

    distances, _ = KDTree(roots).query(roots, 1 + NEIGHBOURS)
    known = np.isfinite(distances).sum(axis=1) - 1
    farthest = distances[np.arange(len(roots)), known]
    return float(np.median(farthest * np.sqrt(np.pi / known))) if len(roots) > 1 else np.inf


@njit(cache=True, nogil=True)
def count(counts: np.ndarray, places: np.ndarray) -> None:
    """Count the places (n, 3) in the cells, in place."""
    for p in range(len(places)):
        add(counts, places[p, 0], places[p, 1], places[p, 2], 1.0)
