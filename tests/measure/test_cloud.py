"""What is told of clouds is what was done to them."""

import numpy as np
import pytest

from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands
from hairpipe.measure.cloud import cloud_table, split_table
from hairpipe.values import Cloud, Particles


@pytest.fixture
def particles() -> Particles:
    """A sheet of hairs 10 cm long, 2 cm apart, eight of them left and eight right of the middle, each linked across."""
    row = lay_strands(1, 0.1, 10, (0.0, -1.0, 0.0), (0.02, 0.0, 0.0), None, 0.0)
    groom = gather_tuft(row, Tuft(rows=16, apart=(0.02, 0.0, 0.0), stray=0.0))
    points = groom.points - groom.points.mean(axis=0) * (1.0, 0.0, 1.0)
    strands = np.repeat(np.arange(16, dtype=np.int32), 11)
    links = np.stack([np.arange(176 - 11), np.arange(11, 176)], axis=1).astype(np.int32)
    rest = points, np.tile([0.0, -1.0, 0.0], (176, 1)), np.full(176, 1e-5)
    return Particles(groom, strands, np.tile(np.linspace(0.0, 0.1, 11), 16), *rest, links, np.ones(165), 0.02, 0.02)


def cloud_of(points: np.ndarray, speed=0.0) -> Cloud:
    return Cloud(points, np.full(points.shape, speed, np.float32), np.tile([0.0, -1.0, 0.0], (len(points), 1)))


def test_clumps_stretch_lost_links_and_speed(particles):
    clumped, stretched = particles.points.copy(), particles.points * (1.0, 1.5, 3.0)
    clumped[:22, 1] *= 0.4
    lost = particles.points.copy()
    lost[particles.strands == 0, 0] -= 0.05
    clouds = {1: cloud_of(particles.points), 2: cloud_of(clumped), 3: cloud_of(stretched), 4: cloud_of(lost, 0.2)}
    row = next(cloud_table(clouds, particles).rows())
    speed = 200.0 * np.sqrt(3.0)
    assert row == pytest.approx((4, 40.0, 50.0, 100.0 * 11 / 165, 100.0 * 11 / 165, 0.0, speed), abs=1e-4)


def test_a_split_and_what_is_left_of_it(particles):
    side = np.where(particles.points[:, :1] > 0.0, 1.0, -1.0)
    opened = particles.points + side * (0.03, 0.0, 0.0)
    mixed = particles.points - side * (particles.strands == 7)[:, None] * (0.035, 0.0, 0.0)
    clouds = {1: cloud_of(particles.points), 2: cloud_of(opened), 3: cloud_of(mixed)}
    row = next(split_table(clouds, particles).rows())
    assert row[:2] == pytest.approx((20.0, 80.0))
    assert row[2] < 0.0 and row[3:] == pytest.approx((100.0, 0.0, 200.0 / 16))  # it, and that which it went beyond
