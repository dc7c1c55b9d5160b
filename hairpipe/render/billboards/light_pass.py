"""Light of a lamp on particles and body: billboards in order of distance from the lamp attenuate the light behind.

The first pass of Bando, Chen, Nishita 2003, Sec. 5:

    l_i = mean of T under the billboard,   T <- T (1 - alpha) there

Transmittance T is stored on the rays of `shadows`; behind the body it is 0.
"""

import numpy as np
from numba import njit

from hairpipe.render.billboards.sprites import Sprites, columns_under, level_of, rows_under, texel_of
from hairpipe.render.billboards.streaks import Levels
from hairpipe.render.raster.triangles import first_centre
from hairpipe.render.shadows import BIAS

DARK = 1e-4
"""Least light: that of the body's own shadow."""


def transmittances(sprites: Sprites, levels: Levels, others: np.ndarray, front: np.ndarray) -> np.ndarray:
    """Return the share of a lamp's light that reaches billboards, (N,), and then other points, (V,); pure.

    sprites  billboards projected to the lamp: rows and columns of its rays, depths away from it
    levels   of the textures of billboards
    others   row and column, from 0 to as many as there are rays, and depth, (V, 3)
    front    depth at which the body begins, infinite outside, (rows, columns)
    """
    order = np.argsort(np.concatenate([sprites.places[:, 2], others[:, 2]]), kind="stable")
    light = np.empty(len(order))
    _pass(light, np.ones(front.shape), sprites, levels, others, front, order)
    return np.maximum(light, DARK)


@njit(cache=True, nogil=True, error_model="numpy")
def _pass(
    light: np.ndarray,
    through: np.ndarray,
    sprites: Sprites,
    levels: Levels,
    others: np.ndarray,
    front: np.ndarray,
    order: np.ndarray,
) -> None:
    """Write the light of all in order of depth, and attenuate the rays, (rows, columns), both in place."""
    count = len(sprites.places)
    for n in order:  # From the lamp on: each attenuates only later ones.
        light[n] = (
            _darken(through, sprites, levels, front, n) if n < count else _read(through, others[n - count], front)
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _darken(through: np.ndarray, sprites: Sprites, levels: Levels, front: np.ndarray, n: int) -> float:
    """Return the light on billboard n, on average over its texture, and attenuate its rays, in place."""
    height, width = through.shape
    column, row, depth = sprites.places[n, 0], sprites.places[n, 1], sprites.places[n, 2]
    axes, halves = (sprites.axes[n, 0], sprites.axes[n, 1]), (sprites.halves[n, 0], sprites.halves[n, 1])
    texture = levels[level_of(levels, halves[1])][sprites.kinds[n]]
    along, across, _ = texture.shape
    opacity, rise = sprites.opacity[n], sprites.rises[n]
    sx = axes[0] / halves[0]
    sy = axes[1] / halves[0]
    wx = -axes[1] / halves[1]
    wy = axes[0] / halves[1]
    taken = total = 0.0
    top, bottom = rows_under(row, axes, halves)
    for i in range(first_centre(top, height), first_centre(bottom, height)):
        y = i + 0.5 - row
        left, right = columns_under(column, y, axes, halves)
        for j in range(first_centre(left, width), first_centre(right, width)):
            x = j + 0.5 - column
            s, w = x * sx + y * sy, x * wx + y * wy
            alpha = min(opacity * texture[texel_of(s, along), texel_of(w, across), 0], 1.0)
            total += alpha
            if depth + s * rise < front[i, j] + BIAS:
                taken += alpha * through[i, j]
            through[i, j] *= 1.0 - alpha
    return taken / total if total > 0.0 else 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _read(through: np.ndarray, at: np.ndarray, front: np.ndarray) -> float:
    """Light at a point, interpolated between the centres of four rays; 1 outside."""
    height, width = through.shape
    x, y = at[0] - 0.5, at[1] - 0.5
    if not (0.0 <= x < width - 1 and 0.0 <= y < height - 1):
        return 1.0
    i, j = int(y), int(x)
    taken = 0.0
    for a in range(2):
        for b in range(2):
            weight = (y - i if a else 1.0 - (y - i)) * (x - j if b else 1.0 - (x - j))
            taken += weight * through[i + a, j + b] * (at[2] < front[i + a, j + b] + BIAS)
    return taken
