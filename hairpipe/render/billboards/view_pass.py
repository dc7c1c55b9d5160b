"""Billboards painted over the film from back to front, except behind the body.

The second pass of Bando, Chen, Nishita 2003, Sec. 5.
"""

import numpy as np
from numba import njit

from hairpipe.render.billboards.sprites import Sprites, columns_under, level_of, rows_under, texel_of
from hairpipe.render.billboards.streaks import Levels
from hairpipe.render.camera import NEAR
from hairpipe.render.raster.triangles import first_centre

SUNK, FADE = 0.010, 0.006
"""Depth below the skin to which a billboard is visible, and of its fading [m]: billboards are flat, skin is round."""


def paint(film: np.ndarray, depth: np.ndarray, sprites: Sprites, colours: np.ndarray, levels: Levels) -> None:
    """Paint billboards over the film, the farthest first, in place.

    film     linear red, green, blue, (height, width, 3) float32
    depth    of the body [m], (height, width)
    sprites  depth [m]; those nearer than NEAR are not drawn
    colours  linear, of the billboards, (N, 3) float64
    levels   of their textures
    """
    order = np.argsort(-sprites.places[:, 2], kind="stable")
    _paint(film, depth, sprites, colours.astype(np.float32), levels, order)


@njit(cache=True, nogil=True, error_model="numpy")
def _paint(
    film: np.ndarray, depth: np.ndarray, sprites: Sprites, colours: np.ndarray, levels: Levels, order: np.ndarray
) -> None:
    height, width = depth.shape
    for n in order:  # The farthest first: each covers those behind it.
        column, row, z = sprites.places[n, 0], sprites.places[n, 1], sprites.places[n, 2]
        if not z > NEAR:
            continue
        axes, halves = (sprites.axes[n, 0], sprites.axes[n, 1]), (sprites.halves[n, 0], sprites.halves[n, 1])
        texture = levels[level_of(levels, halves[1])][sprites.kinds[n]]
        along, across, _ = texture.shape
        opacity = np.float32(sprites.opacity[n])
        rise = sprites.rises[n]
        sx = axes[0] / halves[0]
        sy = axes[1] / halves[0]
        wx = -axes[1] / halves[1]
        wy = axes[0] / halves[1]
        red, green, blue = colours[n]
        top, bottom = rows_under(row, axes, halves)
        for i in range(first_centre(top, height), first_centre(bottom, height)):
            y = i + 0.5 - row
            left, right = columns_under(column, y, axes, halves)
            for j in range(first_centre(left, width), first_centre(right, width)):
                x = j + 0.5 - column
                s = x * sx + y * sy
                before = depth[i, j] + SUNK - z - s * rise
                if before > 0.0:
                    a = texel_of(s, along)
                    b = texel_of(x * wx + y * wy, across)
                    bright = texture[a, b, 1]
                    alpha = np.float32(min(opacity * texture[a, b, 0], 1.0) * min(before * (1.0 / FADE), 1.0))
                    film[i, j, 0] += alpha * (bright * red - film[i, j, 0])
                    film[i, j, 1] += alpha * (bright * green - film[i, j, 1])
                    film[i, j, 2] += alpha * (bright * blue - film[i, j, 2])
