"""Billboards projected to a film or to the view of a lamp: rectangles along the hair that face it, and their textures.

After Bando, Chen, Nishita 2003, Sec. 5: where hair points at the eye, billboards are shorter and more opaque. Textures
are streaks along the hair that a particle represents, faded at the ends and sides: a soft spot looks like smoke.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.values.random_streams import stream

SLIM = 0.5
"""Width of a billboard over its length."""
LEAST = 0.15
"""Sine between hair and ray below which length and opacity are constant."""


class Sprites(NamedTuple):
    """Billboards on a film."""

    places: np.ndarray  # column [pixels], row [pixels] and depth of their middles, (N, 3) float64
    axes: np.ndarray  # directions of the hair on the film, unit vectors, (N, 2)
    halves: np.ndarray  # half of length and width [pixels], (N, 2)
    rises: np.ndarray  # depth of the end towards the tip minus that of the middle, (N,)
    opacity: np.ndarray  # of a streak, more than 1 where hair points along the ray, (N,)
    kinds: np.ndarray  # texture of each billboard, (N,) int64


def lay_sprites(
    places: np.ndarray, along: np.ndarray, scale: np.ndarray, half: float, opacity: float, kinds: np.ndarray
) -> Sprites:
    """Lay billboards on a film; pure.

    places   as in Sprites
    along    change of `places` per metre along the hair, (N, 3)
    scale    pixels of a metre across the ray, (N,)
    half     of the length of a billboard seen from the side [m]
    opacity  of a streak seen from the side

    With theta the angle between hair and ray, length is as sin theta, and opacity as 1/sin theta: as much hair is
    crossed by fewer rays, each of which crosses more.
    """
    run = np.hypot(along[:, 0], along[:, 1])
    axes = np.where(run[:, None] > 0.0, along[:, :2] / np.maximum(run, 1e-300)[:, None], (0.0, 1.0))
    sine = np.maximum(run / scale, LEAST)
    halves = (half * scale)[:, None] * np.stack([sine, np.full_like(sine, SLIM)], axis=1)
    return Sprites(places, axes, halves, half * along[:, 2], opacity / sine, kinds)


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def rows_under(row: float, axes: tuple[float, float], halves: tuple[float, float]) -> tuple[float, float]:
    """Return the first and the last row of a rectangle."""
    reach = halves[0] * abs(axes[1]) + halves[1] * abs(axes[0])
    return row - reach, row + reach


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def columns_under(
    column: float, down: float, axes: tuple[float, float], halves: tuple[float, float]
) -> tuple[float, float]:
    """Return the first and the last column of a rectangle in a row at a distance below its middle; else first > last.

    Of a point (x, y) from the middle, |x ax + y ay| <= half the length and |y ax - x ay| <= half the width.
    """
    ax, ay = axes
    ax, ay = ax if abs(ax) > 1e-9 else 1e-9, ay if abs(ay) > 1e-9 else 1e-9  # Neither is 0: divided by.
    a = (-halves[0] - down * ay) / ax
    b = (halves[0] - down * ay) / ax
    c = (down * ax - halves[1]) / ay
    d = (down * ax + halves[1]) / ay
    return column + max(min(a, b), min(c, d)), column + min(max(a, b), max(c, d))


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def texel_of(share: float, count: int) -> int:
    """Return the index of the texel, of `count` texels from -1 to 1, at a coordinate."""
    return min(max(int(0.5 * (share + 1.0) * count), 0), count - 1)


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def level_of(levels: tuple[np.ndarray, ...], half: float) -> int:
    """Return the finest level of textures, (kinds, along, across, 2) each, with texels not finer than pixels.

    half  of the width of a billboard [pixels]
    """
    level = 0
    while level + 1 < len(levels) and levels[level].shape[2] > 2.0 * half:
        level += 1
    return level


Levels = tuple[np.ndarray, ...]
"""From fine to coarse, each of half as many texels as the one before both ways, (KINDS, along, across, 2) float32:
cover, 0 to 1, and brightness."""

KINDS = 8
"""Number of textures."""
ALONG, ACROSS, STREAKS = 128, 64, 22
"""Texels of the finest level, and streaks in it."""
FINEST = 0.025
"""Standard deviation of the thinnest streak across, over half the width; the widest has three times as much."""
BRIGHTER = 0.55
"""Largest relative deviation of the brightness of a streak from the mean."""


@cache
def streak_levels() -> Levels:
    """Draw the textures, on average as bright as the particle."""
    rng = stream(0, "billboards")

    def drawn(low: float, high: float) -> np.ndarray:
        return rng.uniform(low, high, (KINDS, STREAKS, 1, 1))

    along = (np.arange(ALONG)[:, None] + 0.5) / ALONG * 2.0 - 1.0
    across = (np.arange(ACROSS) + 0.5) / ACROSS * 2.0 - 1.0
    middle = drawn(-0.85, 0.85) + drawn(-0.1, 0.1) * along + drawn(-0.12, 0.12) * along**2
    thin = np.exp(-0.5 * ((across - middle) / (FINEST * drawn(1.0, 3.0))) ** 2)
    begin, end = drawn(-1.0, -0.5), drawn(0.5, 1.0)
    ends = np.clip((along - begin) / 0.5, 0.0, 1.0) * np.clip((end - along) / 0.5, 0.0, 1.0)
    covers = thin * _smooth(ends) * _smooth(np.clip((1.0 - np.abs(across)) / 0.4, 0.0, 1.0)) * drawn(0.5, 1.0)
    bright = (covers * drawn(1.0 - BRIGHTER, 1.0 + BRIGHTER)).sum(axis=1) / np.maximum(covers.sum(axis=1), 1e-6)
    cover = 1.0 - np.prod(1.0 - covers, axis=1)
    shown = np.stack([cover, cover * bright], axis=3)
    levels = []
    while shown.shape[2] >= 2:
        cover, bright = shown[..., 0], shown[..., 1]
        levels.append(np.stack([cover, bright / np.maximum(cover, 1e-6)], axis=3).astype(np.float32))
        shown = 0.25 * (shown[:, ::2, ::2] + shown[:, 1::2, ::2] + shown[:, ::2, 1::2] + shown[:, 1::2, 1::2])
    return tuple(levels)


def _smooth(share: np.ndarray) -> np.ndarray:
    return share * share * (3.0 - 2.0 * share)
