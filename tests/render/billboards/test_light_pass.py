"""Light dies away from billboard to billboard, and ends at the body."""

import numpy as np
import pytest

from hairpipe.render.cloud import DARK, Sprites, transmittances

OPEN, NOBODY = np.full((64, 64), np.inf), np.zeros((0, 3))


def test_each_billboard_takes_its_share_of_the_light_that_is_left(boards, plain) -> None:
    points = np.array([[32.3, 32.4, depth] for depth in (0.5, 3.5, 9.0)] + [[3.0, 3.0, 9.0], [-5.0, 3.0, 9.0]])
    light = transmittances(boards([3.0, 1.0, 2.0, 4.0], 0.3), plain, points, OPEN)
    assert light[:4] == pytest.approx(0.7 ** np.array([2, 0, 1, 3]))
    assert light[4:] == pytest.approx([1.0, 0.7**3, 0.7**4, 1.0, 1.0])


def test_there_is_no_light_behind_what_is_opaque(boards, plain) -> None:
    behind = np.array([[32.3, 32.4, 2.0]])
    assert transmittances(boards([1.0, 3.0], 1.0), plain, behind, OPEN).tolist() == [1.0, DARK, DARK]
    body = np.full((64, 64), 10.0)
    light = transmittances(boards([1.0, 20.0], 0.3), plain, np.array([[20.0, 20.0, 9.0], [20.0, 20.0, 20.0]]), body)
    assert light.tolist() == [1.0, DARK, 1.0, DARK]


def test_a_billboard_half_behind_the_body_takes_half_of_the_light(boards, plain) -> None:
    body = np.where(np.arange(64)[:, None] < 32, 10.0, np.inf) * np.ones(64)
    assert transmittances(boards([20.0], 0.3), plain, NOBODY, body) == pytest.approx([0.5], abs=0.05)


def test_the_order_in_which_they_come_does_not_matter(boards, plain) -> None:
    rng = np.random.default_rng(4)
    sprites = boards(list(rng.random(50)), 0.3)
    sprites = sprites._replace(places=sprites.places + np.c_[rng.uniform(-20, 20, (50, 2)), np.zeros(50)])
    points, order = rng.uniform(0.0, 1.0, (40, 3)) * (64.0, 64.0, 1.0), rng.permutation(50)
    light = transmittances(sprites, plain, points, OPEN)
    assert light.min() < 0.3
    other = transmittances(Sprites(*(field[order] for field in sprites)), plain, points[::-1], OPEN)
    assert np.array_equal(other[:50], light[order]) and np.array_equal(other[50:], light[50:][::-1])
