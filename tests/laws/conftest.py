"""Reads forces and stiffness back out of the banded system that a force adds to."""

import numpy as np
import pytest

from hairpipe.geometry.banded import OFFSET, row_size
from hairpipe.geometry.simd import WIDTH

from ..strand_scenes import scene, straight, triangle  # noqa: F401

REACH = 3


class System:
    """An empty banded system of a few particles in which every lane is the same strand."""

    def __init__(self, points):
        self.x = np.repeat(np.asarray(points, float)[:, :, None], WIDTH, axis=2)
        self.v = np.zeros_like(self.x)
        self.A = np.zeros((len(points), row_size(REACH), WIDTH))
        self.b = np.zeros_like(self.x)
        self.T = np.zeros_like(self.x)

    @property
    def force(self):
        return self.b[:, :, 0]

    @property
    def stiffness(self):
        """The dense symmetric matrix, (3n, 3n)."""
        count = len(self.A)
        dense = np.zeros((count, 3, count, 3))
        for p in range(count):
            dense[p, :, p, :][np.triu_indices(3)] = self.A[p, :OFFSET, 0]
            dense[p, :, p, :] += np.triu(dense[p, :, p, :], 1).T
            for o in range(1, min(REACH, count - 1 - p) + 1):
                block = self.A[p, OFFSET + 9 * (o - 1) : OFFSET + 9 * o, 0].reshape(3, 3)
                dense[p, :, p + o, :] = block
                dense[p + o, :, p, :] = block.T
        return dense.reshape(3 * count, 3 * count)


@pytest.fixture
def system():
    return System
