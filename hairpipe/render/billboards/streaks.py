"""Textures of billboards: streaks along the hair that a particle represents, faded at the ends and sides.

A soft spot instead looks like smoke.
"""

from functools import cache

import numpy as np

from hairpipe.groom.random_streams import stream

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
