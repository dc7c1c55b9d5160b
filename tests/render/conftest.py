"""Things to take pictures of, whose outlines are known."""

from typing import Any

import numpy as np
import pytest

from hairpipe.render.camera import Shot
from hairpipe.render.film import develop
from hairpipe.render.portrait import expose_portrait
from hairpipe.values import Mesh, Strands


def draw_portrait(hair: Strands, body: Mesh | None, shot: Shot, *style: Any, **more: Any) -> np.ndarray:
    return develop(expose_portrait(hair, body, shot, *style, **more), shot.grain)


def make_sphere(centre: np.ndarray, radius: float, rings: int = 40) -> Mesh:
    """Latitude rings of twice as many points each, counter-clockwise from outside."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, rings), np.arange(2 * rings) * np.pi / rings, indexing="ij")
    outward = np.stack([np.sin(polar) * np.sin(around), np.cos(polar), np.sin(polar) * np.cos(around)], axis=2)
    corner = np.arange(rings * 2 * rings).reshape(rings, 2 * rings)
    here, below = corner[:-1].ravel(), corner[1:].ravel()
    beside, across = np.roll(corner, -1, 1)[:-1].ravel(), np.roll(corner, -1, 1)[1:].ravel()
    triangles = np.concatenate([np.stack([here, below, beside], 1), np.stack([beside, below, across], 1)])
    return Mesh(centre + radius * outward.reshape(-1, 3), triangles.astype(np.int32))


def make_strands(points: np.ndarray, diameter: float = 80e-6) -> Strands:
    """Bundle strands of as many points each, (S, n, 3)."""
    count, each, _ = points.shape
    flat = np.ascontiguousarray(points.reshape(-1, 3), np.float32)
    return Strands(flat, np.zeros_like(flat), np.arange(0, count * each + 1, each, dtype=np.int32), diameter)


@pytest.fixture(scope="session")
def head() -> Mesh:
    """A sphere of 9 cm about (0, 1.6, 0)."""
    return make_sphere(np.array([0.0, 1.6, 0.0]), 0.09)


@pytest.fixture(scope="session")
def coarse_head() -> Mesh:
    """The same of few triangles."""
    return make_sphere(np.array([0.0, 1.6, 0.0]), 0.09, 7)


@pytest.fixture(scope="session")
def hair() -> Strands:
    """300 arcs of 20 cm that stand off the upper half of the head and fall."""
    rng = np.random.default_rng(7)
    outward = rng.normal(size=(300, 3))
    outward[:, 1] = np.abs(outward[:, 1])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    s = np.linspace(0.0, 0.2, 16)[None, :, None]
    fall = np.array([0.0, -4.0, 0.0]) * s**2
    return make_strands([0.0, 1.6, 0.0] + outward[:, None] * (0.09 + s) + fall)
