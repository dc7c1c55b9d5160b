"""Shading of hair: Kajiya and Kay 1989, with the two shifted highlights of Marschner et al. 2003.

A share of the diffuse light may be Lambert's, by normals of hair as one body (Petrovic, Henne, Anderson 2005, Sec. 4.1,
who do not print the form of it): (1 - b) sin(t,l) + b max(0, N.l). Where there is no normal, b is 0.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.render.lights import Light
from hairpipe.render.shadows import Shadow, look_up_all

AMBIENT = 0.12
"""Light that comes from everywhere."""
MATT, SHEEN, GLOSS = 0.42, 0.6, 0.15
"""Strength of the diffuse light, of the wide highlight in the hair's colour, and of the narrow white one."""
BACK = 0.4
"""What a hair lit from behind sends to the eye, over what it sends when lit from the eye's side."""
DENSITY, TINT = 0.15, 0.6
"""How fast light dies away in hair, and how much faster where the hair is dark."""
LIFT = 1.0
"""How far towards the lamp its shadow is looked up, so that a hair does not shade itself [cells]."""
TILT = math.radians(4.0)
"""Tilt of a hair's scales: twice this moves the narrow highlight to the root, three times the wide one to the tip."""


class Fibres(NamedTuple):
    """Points of hair that is lit.

    points   [m], (p, 3) float64
    along    unit vectors along the hair, (p, 3)
    facing   normals of hair as one body, each as long as its share b of the diffuse light, (p, 3)
    colours  linear, (p, 3)
    tilts    angles that highlights are moved by [rad], (p,)
    """

    points: np.ndarray
    along: np.ndarray
    facing: np.ndarray
    colours: np.ndarray
    tilts: np.ndarray


def shade_hair(
    points: np.ndarray,
    offsets: np.ndarray,
    colour: np.ndarray,
    eye: np.ndarray,
    shadows: list[Shadow],
    facing: np.ndarray,
) -> np.ndarray:
    """Light that the points of the strands send to the eye, linear, (p, 3) float64.

    points   [m], (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    colour   of the hair, linear, (3,)
    eye      [m], (3,)
    shadows  of every lamp
    facing   normals of hair as one body, each as long as its share b of the diffuse light, (p, 3)
    """
    colours = strand_colours(colour, offsets)
    fibres = Fibres(points, tangents(points, offsets), facing, colours, strand_tilts(offsets))
    shed = AMBIENT * colours
    for shadow in shadows:
        between = look_up_all(shadow.depth, shadow.to_cells, points + LIFT * shadow.cell * shadow.light.towards)
        add_light(shed, fibres, eye, shadow.light, between)
    return shed


def strand_colours(colour: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Colour the points of the strands: each strand a shade of its own, darker at the root, lighter at the tip.

    colour  of the hair, linear, (3,)

    Returns (p, 3) float64.
    """
    counts = np.diff(offsets)
    shade, warmth = noise(len(counts), 1), noise(len(counts), 2)
    tint = np.stack([1.0 + 0.10 * warmth, np.ones(len(counts)), 1.0 - 0.10 * warmth], axis=1)
    along = (np.arange(offsets[-1]) - np.repeat(offsets[:-1], counts)) / np.repeat(np.maximum(counts - 1, 1), counts)
    strength = np.repeat(np.exp2(0.6 * shade), counts) * (0.8 + 0.4 * along)
    return np.clip(colour * np.repeat(tint, counts, axis=0) * strength[:, None], 0.0, 0.95)


def strand_tilts(offsets: np.ndarray) -> np.ndarray:
    """Angle the highlights of every point's strand are moved by, a little different for each strand [rad], (p,)."""
    counts = np.diff(offsets)
    return np.repeat(TILT * (1.0 + 0.9 * noise(len(counts), 3)), counts)


def noise(count: int, seed: int) -> np.ndarray:
    """Numbers in -1..1 that depend on the index and the seed alone, (count,) float64 (the mixer of splitmix64)."""
    x = (np.arange(count, dtype=np.uint64) + np.uint64(seed << 40)) * np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return (x >> np.uint64(11)).astype(float) * 2.0**-52 - 1.0


@njit(cache=True, nogil=True)
def tangents(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Unit vectors along the strands at their points, root to tip, by central differences, (p, 3) float64."""
    along = np.zeros(points.shape)
    for s in range(len(offsets) - 1):
        first, last = offsets[s], offsets[s + 1] - 1
        for i in range(first, last + 1):
            step = points[min(i + 1, last)] - points[max(i - 1, first)]
            length = math.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
            if length > 0.0:
                along[i] = step / length
    return along


@njit(cache=True, nogil=True)
def add_light(shed: np.ndarray, fibres: Fibres, eye: np.ndarray, light: Light, between: np.ndarray) -> None:
    """Add what one lamp makes points of fibres send to the eye, into `shed` (p, 3).

    eye      [m], (3,)
    between  optical depth of what is between them and the lamp, (p,)

    With l and e unit vectors to lamp and eye and t along the hair, diffuse kd sin(t,l), or as above, and specular
    ks max(0, sin(t,l) sin(t,e) - cos(t,l) cos(t,e))^n (Kajiya and Kay 1989), which is -cos of the sum of both angles: a
    highlight is moved along the hair by adding to that sum. Both are weighted by which side is lit,
    (1 + kappa)/2 + r (1 - kappa)/2 with kappa = cos(t x l, t x e) (Goldman 1997). Light dies away as exp(-depth),
    slower in the colour of the hair: what comes through is tinted.
    """
    points, along, facing, colours, tilts = fibres
    lx, ly, lz = light.towards
    for i in range(len(shed)):
        tx, ty, tz = along[i, 0], along[i, 1], along[i, 2]
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        ex, ey, ez = eye[0] - x, eye[1] - y, eye[2] - z
        away = math.sqrt(ex * ex + ey * ey + ez * ez)
        cos_l = tx * lx + ty * ly + tz * lz
        cos_e = (tx * ex + ty * ey + tz * ez) / away
        sin_l = math.sqrt(max(0.0, 1.0 - cos_l * cos_l))
        sin_e = math.sqrt(max(0.0, 1.0 - cos_e * cos_e))
        cos_sum, sin_sum = cos_l * cos_e - sin_l * sin_e, sin_l * cos_e + cos_l * sin_e
        kappa = ((ex * lx + ey * ly + ez * lz) / away - cos_l * cos_e) / max(sin_l * sin_e, 1e-6)
        side = 0.5 * (1.0 + kappa) + 0.5 * BACK * (1.0 - kappa)
        nx, ny, nz = facing[i, 0], facing[i, 1], facing[i, 2]
        share = math.sqrt(nx * nx + ny * ny + nz * nz)
        diffuse = MATT * ((1.0 - share) * sin_l + max(0.0, nx * lx + ny * ly + nz * lz))
        gloss = GLOSS * max(0.0, -cosine(cos_sum, sin_sum, -2.0 * tilts[i])) ** 64
        sheen = SHEEN * max(0.0, -cosine(cos_sum, sin_sum, 3.0 * tilts[i])) ** 16
        for c in range(3):
            through = math.exp(-between[i] * DENSITY * (1.0 + TINT * (1.0 - colours[i, c])))
            shed[i, c] += light.colour[c] * through * side * (colours[i, c] * (diffuse + sheen) + gloss)


@njit(cache=True, nogil=True, inline="always")
def cosine(cos_sum: float, sin_sum: float, shift: float) -> float:
    """Cosine of an angle plus a shift."""
    return cos_sum * math.cos(shift) - sin_sum * math.sin(shift)
