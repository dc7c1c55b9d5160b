"""Solids of revolution whose surface and inside are known: ellipsoids, and capsules, which are spheres drawn out."""

from typing import NamedTuple

import numpy as np

from hairpipe.values import Mesh

RINGS = 96
"""Points from pole to pole, and around."""


class Solid(NamedTuple):
    """A ball of semi-axes `semi`, its halves drawn `half` apart from the centre along x, in its own frame.

    semi    [m], (3,) float64
    half    [m]
    centre  [m], (3,) float64
    """

    semi: np.ndarray
    half: float
    centre: np.ndarray

    @property
    def radius(self) -> float:
        """Of the ball around it [m]."""
        return max(float(self.semi[0]) + self.half, *self.semi[1:].tolist())

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points [m], (n, 3), are inside, (n,) bool."""
        off = points - self.centre
        off = off - np.clip(off, -self.half, self.half) * (1.0, 0.0, 0.0)
        return ((off / self.semi) ** 2).sum(axis=1) < 1.0

    def mesh(self) -> Mesh:
        """Return the surface; its points lie on the solid's."""
        angles = np.linspace(0.0, np.pi, RINGS)
        profile = np.stack([-np.cos(angles), np.sin(angles)], axis=1)
        left, right = profile[: RINGS // 2], profile[RINGS // 2 :]
        between = np.linspace(-self.half, self.half, RINGS // 2)[1:-1] if self.half else np.empty(0)
        along = np.concatenate([left[:, 0] * self.semi[0] - self.half, between, right[:, 0] * self.semi[0] + self.half])
        wide = np.concatenate([left[:, 1], np.ones(len(between)), right[:, 1]])
        around = 2.0 * np.pi * np.arange(RINGS) / RINGS
        ring = np.stack([np.cos(around) * self.semi[1], np.sin(around) * self.semi[2]], axis=1)
        inner = np.empty((len(along) - 2, RINGS, 3))
        inner[..., 0], inner[..., 1:] = along[1:-1, None], wide[1:-1, None, None] * ring
        poles = np.array([[along[0], 0.0, 0.0], [along[-1], 0.0, 0.0]])
        return Mesh(np.concatenate([inner.reshape(-1, 3), poles]) + self.centre, tube(len(along) - 2, RINGS))


def tube(rings: int, sectors: int) -> np.ndarray:
    """Return the triangles of rings of points, one after the other, and the two poles behind them, (m, 3) int32."""
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(sectors), indexing="ij")
    a = (i * sectors + j).ravel()
    b = (i * sectors + (j + 1) % sectors).ravel()
    first = np.arange(sectors)
    last = (rings - 1) * sectors + first
    start = rings * sectors
    end = rings * sectors + 1
    sides = [np.stack([a, a + sectors, b], 1), np.stack([b, a + sectors, b + sectors], 1)]
    caps = [np.stack([np.full(sectors, start), first, np.roll(first, -1)], 1)]
    caps += [np.stack([np.full(sectors, end), np.roll(last, -1), last], 1)]
    return np.concatenate([*sides, *caps]).astype(np.int32)


def ellipsoid(semi: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Solid:
    """Make an ellipsoid."""
    return Solid(np.array(semi), 0.0, np.array(centre))


def capsule(radius: float, half: float, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Solid:
    """Make a capsule along x: all within a radius of a line from -half to half [m]."""
    return Solid(np.full(3, radius), half, np.array(centre))
