"""Billboards without streaks, whose coverage is known."""

from collections.abc import Callable

import numpy as np
import pytest

from hairpipe.render.cloud import Levels, Sprites, lay_sprites


@pytest.fixture(scope="session")
def plain() -> Levels:
    """A texture that covers everything, at as many levels as streaks have: the same kernels."""
    return (np.ones((1, 8, 4, 2), np.float32),) * 6


@pytest.fixture(scope="session")
def boards() -> Callable[..., Sprites]:
    """Lay billboards of 20 pixels by 10 that face the eye, or lean away from it by an angle [deg], at depths [m]."""

    def lay(depths: list[float], opacity: float, lean: float = 0.0, turn: float = 0.5) -> Sprites:
        count = len(depths)
        places = np.column_stack([np.tile((32.3, 32.4), (count, 1)), depths])
        ahead, aside = np.sin(np.radians(lean)), 100.0 * np.cos(np.radians(lean))
        along = np.tile((aside * np.cos(turn), aside * np.sin(turn), ahead), (count, 1))
        return lay_sprites(places, along, np.full(count, 100.0), 0.1, opacity, np.zeros(count, int))

    return lay
