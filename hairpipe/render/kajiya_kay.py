"""Shading of hair: Kajiya and Kay 1989, with the two shifted highlights of Marschner et al. 2003.

A share of the diffuse light may be Lambert's, by normals of hair as one body (Petrovic, Henne, Anderson 2005, Sec. 4.1,
who do not print the form of it): (1 - b) sin(t,l) + b max(0, N.l). Where there is no normal, b is 0.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.render.lights import Light, Shade
from hairpipe.values import Normals

AMBIENT = 0.12
"""Ambient light."""
MATT, SHEEN, GLOSS = 0.42, 0.6, 0.15
"""Strength of the diffuse light, of the wide highlight in the hair's colour, and of the narrow white one."""
BACK = 0.4  # light of a hair lit from behind, over that of a hair lit from the eye's side
DENSITY, TINT = 0.15, 0.6
"""Attenuation of light per hair, and its increase in dark hair."""
DARK = 9.0  # exponent of attenuation beyond which light is invisible
LIFT = 1.0  # distance towards the lamp at which the shadow is sampled, so that a hair does not shade itself [cells]
TILT = math.radians(4.0)
"""Tilt of a hair's scales: twice this moves the narrow highlight to the root, three times the wide one to the tip."""


class Fibres(NamedTuple):
    """Points of hair that is lit."""

    points: np.ndarray  # [m], (p, 3) float64
    along: np.ndarray  # unit vectors along the hair, (p, 3)
    facing: np.ndarray  # normals of hair as one body, each as long as its share b of the diffuse light, (p, 3)
    colours: np.ndarray  # linear, (p, 3)
    tilts: np.ndarray  # sines of the angles that scales are tilted by, (p,)


def shade_hair(
    points: np.ndarray,
    offsets: np.ndarray,
    sites: np.ndarray,
    colour: np.ndarray,
    eye: np.ndarray,
    shadows: Sequence[Shade],
    facing: np.ndarray | None = None,
) -> np.ndarray:
    """Return the light from sites on the strands to the eye, linear, (n, 3) float64; the colour is linear, (3,).

    sites    2 i at point i, 2 i + 1 in the middle of the segment from there, (n,) int64
    shadows  of every lamp
    facing   normals of hair as one body, each as long as its share b of the diffuse light, (p, 3); None: no share
    """
    fibres = lay_fibres(points, offsets, sites, colour, facing)
    shed = AMBIENT * fibres.colours
    for shadow in shadows:
        between = shadow.between(fibres.points + LIFT * shadow.cell * shadow.light.towards)
        add_light(shed, fibres, eye, shadow.light, between)
    return shed


def facing_of(normals: Normals | None, count: int, share: float) -> np.ndarray | None:
    """Return normals as long as their share of the diffuse light, (p, 3); BadInput where they are not of the points."""
    if normals is not None and len(normals.vectors) != count:
        what = f"{len(normals.vectors)} normals of {count} points"
        raise BadInput(what, where="in.normals", right="the normals of this hair")
    return None if normals is None else share * normals.vectors.astype(float)


def lay_fibres(
    points: np.ndarray, offsets: np.ndarray, sites: np.ndarray, colour: np.ndarray, facing: np.ndarray | None
) -> Fibres:
    """Find the inputs of shading at sites on the strands; arguments as of `shade_hair`."""
    strand = np.repeat(np.arange(len(offsets) - 1, dtype=np.int32), np.diff(offsets))[sites // 2]
    places, along = lie(points, offsets, strand, sites)
    normals = np.zeros_like(places) if facing is None else 0.5 * (facing[sites // 2] + facing[(sites + 1) // 2])
    colours = strand_colours(colour, offsets, strand, sites)
    tilts = np.sin(TILT * (1.0 + 0.9 * noise(len(offsets) - 1, 3)))[strand]
    return Fibres(places, along, normals, colours, tilts)


def strand_colours(colour: np.ndarray, offsets: np.ndarray, strand: np.ndarray, sites: np.ndarray) -> np.ndarray:
    """Return the linear colours of sites, (n, 3): each strand has a shade of its own, darker at the root than the tip.

    colour, strand  of the hair, linear, (3,), and of the sites, (n,); sites as in `shade_hair`
    """
    counts = np.diff(offsets)
    shade, warmth = noise(len(counts), 1), noise(len(counts), 2)
    tints = colour * np.stack([1.0 + 0.10 * warmth, np.ones(len(counts)), 1.0 - 0.10 * warmth], axis=1)
    tints *= np.exp2(0.6 * shade)[:, None]
    along = (0.5 * sites - offsets[strand]) / np.maximum(counts - 1, 1)[strand]
    return np.minimum(tints[strand] * (0.8 + 0.4 * along)[:, None], 0.95)


def noise(count: int, seed: int) -> np.ndarray:
    """Numbers in -1..1 that depend on the index and the seed alone, (count,) float64 (the mixer of splitmix64)."""
    x = (np.arange(count, dtype=np.uint64) + np.uint64(seed << 40)) * np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return (x >> np.uint64(11)).astype(float) * 2.0**-52 - 1.0


@njit(cache=True, nogil=True)
def lie(
    points: np.ndarray, offsets: np.ndarray, strand: np.ndarray, sites: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return where sites of strands lie, and unit vectors there along the curve from root to tip, (n, 3) float64 each.

    Curves are Catmull and Rom's: at point i along p[i+1] - p[i-1]; in the middle between p1 and p2
    (9 (p1 + p2) - p0 - p3)/16, along 11 (p2 - p1) - (p3 - p0). Beyond the ends of a strand its points are mirrored.
    """
    places, along = np.empty((len(sites), 3)), np.empty((len(sites), 3))
    for n in range(len(sites)):
        i = sites[n] // 2
        first = offsets[strand[n]]
        last = offsets[strand[n] + 1] - 1
        length = 0.0
        for d in range(3):
            if sites[n] % 2:
                p1 = points[i, d]
                p2 = points[i + 1, d]
                p0 = points[i - 1, d] if i > first else 2.0 * p1 - p2
                p3 = points[i + 2, d] if i + 1 < last else 2.0 * p2 - p1
                places[n, d] = (9.0 * (p1 + p2) - p0 - p3) / 16.0
                along[n, d] = 11.0 * (p2 - p1) - (p3 - p0)
            else:
                places[n, d] = points[i, d]
                along[n, d] = points[min(i + 1, last), d] - points[max(i - 1, first), d]
            length += along[n, d] ** 2
        for d in range(3):
            along[n, d] /= max(math.sqrt(length), 1e-300)
    return places, along


@njit(cache=True, nogil=True)
def add_light(shed: np.ndarray, fibres: Fibres, eye: np.ndarray, light: Light, between: np.ndarray) -> None:
    """Add the light of one lamp that points of fibres scatter to the eye, into `shed` (p, 3).

    between  optical depth between them and the lamp, (p,)

    With l and e unit vectors to lamp and eye and t along the hair, diffuse kd sin(t,l), or as above, and specular
    ks max(0, sin(t,l) sin(t,e) - cos(t,l) cos(t,e))^n (Kajiya and Kay 1989), which is -cos of the sum of both angles: a
    highlight is moved along the hair by adding to that sum. Both are weighted by which side is lit,
    (1 + kappa)/2 + r (1 - kappa)/2 with kappa = cos(t x l, t x e) (Goldman 1997). Light dies away as exp(-depth),
    slower in the colour of the hair: what comes through is tinted.
    """
    points, along, facing, colours, tilts = fibres
    lx, ly, lz = light.towards
    for i in range(len(shed)):
        if between[i] * DENSITY > DARK:  # Light in deep shadow is invisible.
            continue
        tx, ty, tz = along[i, 0], along[i, 1], along[i, 2]
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        ex, ey, ez = eye[0] - x, eye[1] - y, eye[2] - z
        away = math.sqrt(ex * ex + ey * ey + ez * ez)
        cos_l = tx * lx + ty * ly + tz * lz
        cos_e = (tx * ex + ty * ey + tz * ez) / away
        sin_l = math.sqrt(max(0.0, 1.0 - cos_l * cos_l))
        sin_e = math.sqrt(max(0.0, 1.0 - cos_e * cos_e))
        cos_sum = cos_l * cos_e - sin_l * sin_e
        sin_sum = sin_l * cos_e + cos_l * sin_e
        kappa = ((ex * lx + ey * ly + ez * lz) / away - cos_l * cos_e) / max(sin_l * sin_e, 1e-6)
        side = 0.5 * (1.0 + kappa) + 0.5 * BACK * (1.0 - kappa)
        nx, ny, nz = facing[i, 0], facing[i, 1], facing[i, 2]
        share = math.sqrt(nx * nx + ny * ny + nz * nz)  # Normals are as long as their share of the diffuse light.
        diffuse = MATT * ((1.0 - share) * sin_l + max(0.0, nx * lx + ny * ly + nz * lz))
        s = tilts[i]
        double = 1.0 - 2.0 * s * s  # cosines of both angles
        triple = math.sqrt(1.0 - s * s) * (1.0 - 4.0 * s * s)
        gloss = GLOSS * max(0.0, -cos_sum * double - sin_sum * 2.0 * s * math.sqrt(1.0 - s * s)) ** 64
        sheen = SHEEN * max(0.0, sin_sum * s * (3.0 - 4.0 * s * s) - cos_sum * triple) ** 16
        for c in range(3):
            through = math.exp(-between[i] * DENSITY * (1.0 + TINT * (1.0 - colours[i, c])))
            shed[i, c] += light.colour[c] * through * side * (colours[i, c] * (diffuse + sheen) + gloss)
