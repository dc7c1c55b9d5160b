"""Shading of the body: diffuse, red at the terminator, with a faint highlight."""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from hairpipe.render.lights import Light, Shade
from hairpipe.render.raster.surface import Surface

CLAY = np.array([0.25, 0.21, 0.19])
"""Colour of the body, linear."""
WRAP = np.array([0.38, 0.22, 0.15])
"""Width of wrapped diffuse light: largest for red, as in skin."""
IRRADIANCE = math.pi * (1.0 + WRAP.mean()) * 4.0 / 6.0
"""Of a surface that faces a lamp of colour 1, where light is physical and a sphere as bright as the body is here.

Here the mean of ((n.l + w)/(1 + w))^2 over all normals is (1 + w)/6, there that of n.l where positive is 1/4.
"""
SHEEN = 0.25
"""Strength of the highlight."""
AMBIENT = 0.05
"""Light that comes from everywhere."""
DENSITY = 0.2
"""Attenuation of light by the hair before the body, per hair."""
GRAZING = 0.3
"""Cosine to the lamp below which cells are too coarse for self-shadowing: light fades to zero."""
LIFT = 1.5
"""Distance from the surface at which the shadow is sampled [cells]."""


def shade_skin(surface: Surface, colours: np.ndarray, eye: np.ndarray, shadows: Sequence[Shade]) -> np.ndarray:
    """Return the light from visible points of the body to the eye, linear, (n, 3) float64.

    colours  of the points, linear, (n, 3)
    eye      [m], (3,)
    shadows  of every lamp
    """
    shed = AMBIENT * colours
    for shadow in shadows:
        between = shadow.between(surface.points + LIFT * shadow.cell * surface.normals)
        add_light(shed, surface.points, surface.normals, colours, eye, shadow.light, between)
    return shed


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
