"""The film: backdrop, outlines, tone mapping and motion blur.

For motion blur, pictures of hair and body at instants of the exposure are summed, and hair is not smeared along its
path, so that occlusion is right at each instant. Few instants would leave sharp copies of a hair: each strand has a
time offset of its own, a fraction of the interval.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera
from hairpipe.render.kajiya_kay import noise
from hairpipe.values import Mesh, Strands

EXPOSURE, VIGNETTE = 0.75, 0.6  # exposure of the film, and vignetting towards the corners
CENTRE = np.array([0.30, 0.325, 0.36])  # brightest colour of the backdrop, linear
EDGE = np.array([0.06, 0.07, 0.09])
"""Darkest colour of the backdrop, linear."""
FAR = 1e6  # depth of the background [m]
STEEP = 8.0  # smallest change of depth between pixels, over their distance, of an outline


def backdrop(height: int, width: int) -> np.ndarray:
    """Return a film with a plain wall, brightest in the middle, linear, (height, width, 3) float32."""
    return _wall(height, width).copy()


@lru_cache(maxsize=1)
def _wall(height: int, width: int) -> np.ndarray:
    down = np.exp(-5.0 * ((np.arange(height) + 0.5) / height - 0.46) ** 2)
    along = np.exp(-5.0 * ((np.arange(width) + 0.5) / width - 0.5) ** 2)
    glow = np.outer(down, along).astype(np.float32)
    return np.stack([edge + (centre - edge) * glow for edge, centre in zip(EDGE, CENTRE, strict=True)], axis=2)


def outlines(depth: np.ndarray, focal: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the pixels on either side of the outlines of a body: rows and columns.

    depth  of the body along the view, infinite outside [m], (height, width)
    focal  length of the camera [pixels]
    """
    outline = np.zeros(depth.shape, bool)
    near = np.where(np.isfinite(depth), depth, FAR)
    for axis in (0, 1):
        ahead, behind = np.delete(near, 0, axis), np.delete(near, -1, axis)
        change = np.abs(ahead - behind) * focal > STEEP * np.minimum(ahead, behind)
        first = np.pad(change, [(int(a == axis), 0) for a in (0, 1)])
        outline |= first | np.pad(change, [(0, int(a == axis)) for a in (0, 1)])
    rows, columns = np.nonzero(outline)
    return rows, columns


def soften(film: np.ndarray, outline: tuple[np.ndarray, np.ndarray], before: np.ndarray) -> None:
    """Smooth the outline of a body on the film, (height, width, 3), in place: weights 1 2 1 along rows and columns.

    outline  its pixels: rows and columns
    before   light of these pixels before hair was drawn, (n, 3): pixels changed by hair are not smoothed
    """
    bare = (film[outline] == before).all(axis=1)
    rows, columns = outline[0][bare], outline[1][bare]
    smooth = np.zeros((len(rows), 3))
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            near = np.clip(rows + i, 0, len(film) - 1), np.clip(columns + j, 0, film.shape[1] - 1)
            smooth += (2 - abs(i)) * (2 - abs(j)) / 16 * film[near]
    film[rows, columns] = smooth


def develop(film: np.ndarray, grain: int) -> np.ndarray:
    """Make the picture of a film with `grain` pixels across each pixel, (height/grain, width/grain, 3) uint8, sRGB.

    Bright light is compressed by the curve x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), a fit to ACES by Narkowicz
    2015, before the film is averaged, so that single bright points do not dominate a pixel.
    """
    levels = np.linspace(0.0, 1.0, 4097)
    encoded = np.where(levels <= 0.0031308, 12.92 * levels, 1.055 * levels ** (1 / 2.4) - 0.055)
    return expose(film, np.rint(255.0 * encoded).astype(np.uint8), grain)


@njit(cache=True, nogil=True, error_model="numpy")
def expose(film: np.ndarray, encoded: np.ndarray, grain: int) -> np.ndarray:
    """Compress the light, average grain x grain pixels, and look the code up in a table over 0..1."""
    height, width = film.shape[0] // grain, film.shape[1] // grain
    reach = 1.0 / (height**2 + width**2)
    picture = np.empty((height, width, 3), np.uint8)
    total = np.empty((width, 3))
    light = np.empty(width)
    for i in range(height):
        for j in range(width):
            light[j] = EXPOSURE * (1.0 - VIGNETTE * reach * ((2 * i - height) ** 2 + (2 * j - width) ** 2))
        total[:] = 0.0
        for k in range(grain * grain):
            for j in range(width):
                for c in range(3):
                    x = light[j] * film[grain * i + k // grain, grain * j + k % grain, c]
                    total[j, c] += x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
        for j in range(width):
            for c in range(3):
                level = min(max(total[j, c] / grain**2, 0.0), 1.0)
                picture[i, j, c] = encoded[int(level * (len(encoded) - 1) + 0.5)]
    return picture


def linear(colour: tuple[float, float, float]) -> np.ndarray:
    """Undo the sRGB encoding of a colour, each of 0..1 (IEC 61966-2-1), (3,) float64."""
    encoded = np.asarray(colour, float)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


STRIDE, MOST = 4.0, 16  # pixels that all but FEW of the points move between two instants; largest number of instants
FEW = 0.02


def instants(hair: Strands, body: Mesh, camera: Camera, shutter: float) -> Iterator[tuple[np.ndarray, Mesh]]:
    """Yield points of the hair [m], (p, 3) float64, and the body, at instants from -shutter/2 to shutter/2 [s].

    Both move with constant velocities. Raises BadInput where a velocity of the hair is not finite.
    """
    points = np.asarray(hair.points, float)
    if shutter == 0.0:
        yield points, body
        return
    if not np.isfinite(hair.velocities).all():
        raise BadInput("a velocity is not finite", where="hair", right="shutter = 0 draws hair without velocities")
    way = shutter * hair.velocities.astype(float)
    begin, end = (camera.project(points + side * way) for side in (-0.5, 0.5))
    pixels = np.quantile(np.hypot(*(end - begin)[:, :2].T), 1.0 - FEW)
    count = int(np.clip(np.ceil(pixels / STRIDE), 1, MOST))
    late = np.repeat(0.5 * noise(len(hair.offsets) - 1, 4), np.diff(hair.offsets))[:, None]
    for n in range(count):
        part = (n + 0.5) / count - 0.5
        yield points + (part + late / count) * way, Mesh(body.points + part * shutter * body.rates, body.triangles)
