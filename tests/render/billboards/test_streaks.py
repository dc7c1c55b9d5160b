"""Textures of streaks: what covers a billboard from near covers it from far away."""

import numpy as np

from hairpipe.render.cloud import KINDS, streak_levels


def test_coarser_levels_cover_as_much_and_are_as_bright() -> None:
    covers = np.array([level[..., 0].mean(axis=(1, 2)) for level in streak_levels()])
    light = np.array([level.prod(axis=3).mean(axis=(1, 2)) for level in streak_levels()])
    assert np.ptp(covers, axis=0).max() < 1e-5 and np.ptp(light, axis=0).max() < 1e-5
    assert covers.min() > 0.1 and covers.max() < 0.6


def test_streaks_run_along_the_hair_and_fade_at_ends_and_sides() -> None:
    cover = streak_levels()[0][..., 0]
    assert cover.min() >= 0.0 and cover.max() <= 1.0
    assert np.abs(np.diff(cover, axis=1)).mean() < 0.25 * np.abs(np.diff(cover, axis=2)).mean()
    rim = (cover[:, 0], cover[:, -1], cover[:, :, 0], cover[:, :, -1])
    assert max(edge.mean() for edge in rim) < 0.05 * cover.mean()


def test_kinds_differ() -> None:
    cover = streak_levels()[0][..., 0].reshape(KINDS, -1)
    assert np.abs(np.corrcoef(cover) - np.eye(KINDS)).max() < 0.9
