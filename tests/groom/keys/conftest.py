"""A small groom, some of whose hairs are keys."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.engine import Time
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.groom.sampling import thinned
from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands
from hairpipe.nodes.interpolate_hair import interpolate_hair
from hairpipe.values import Groom, Strands

ROW = lay_strands(4, 0.1, 6, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0)


@pytest.fixture(scope="session")
def groom() -> Groom:
    """Twelve hairs of 6 segments that stray."""
    return gather_tuft(ROW, Tuft(rows=3, apart=(0.0, 0.0, 0.01), stray=10.0))


@pytest.fixture(scope="session")
def keys(groom) -> Groom:
    """Every fifth of them."""
    return thinned(groom, 5)


@pytest.fixture(scope="session")
def row() -> Groom:
    """Four parallel hairs beside each other."""
    return ROW


def strands_at(groom: Groom, points: np.ndarray, velocities: np.ndarray | float = 0.0) -> Strands:
    speeds = np.broadcast_to(velocities, points.shape).astype(np.float32)
    return Strands(np.ascontiguousarray(points, float), speeds, groom.offsets, 8e-5)


@pytest.fixture(scope="session")
def at() -> Callable[..., Strands]:
    """Give a groom's strands at some points."""
    return strands_at


def show(hair, keys, groom, body=None, ends=None, surface=None, parting=30.0, **settings):
    followed = weigh_keys(keys, groom, parting)
    return interpolate_hair(hair, keys, groom, body, ends, surface, None, Time(1, 24.0), followed, **settings)


@pytest.fixture(scope="session")
def shown() -> Callable[..., Strands]:
    """Interpolate hair at one frame."""
    return show


@pytest.fixture(scope="session")
def bent() -> Callable[..., np.ndarray]:
    """Bend every strand of a groom without stretching it: each segment is turned at random by up to so many degrees."""

    def bend(groom: Groom, angle: float, seed: int) -> np.ndarray:
        rng = np.random.default_rng(seed)
        axes = rng.normal(size=groom.points.shape)
        axes *= np.radians(angle) * rng.random((len(axes), 1)) / np.linalg.norm(axes, axis=1, keepdims=True)
        points = groom.points.copy()
        for begin, end in zip(groom.offsets, groom.offsets[1:], strict=False):
            turns = Rotation.from_rotvec(axes[begin + 1 : end])
            steps = turns.apply(np.diff(groom.points[begin:end], axis=0))
            points[begin + 1 : end] = points[begin] + np.cumsum(steps, axis=0)
        return points

    return bend


@pytest.fixture(scope="session")
def nameless() -> Callable[[Groom], Groom]:
    """Give hairs other ids, so that none of them is a key."""
    return lambda groom: replace(groom, ids=groom.ids + 1000)
