"""Rotations as vectors: there and back, also near half a turn, and their rates."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.geometry.rotations import exponential, inverse_jacobian, jacobian, logarithm

AXES = np.random.default_rng(0).normal(size=(20, 3))
VECTORS = [
    angle * axis / np.linalg.norm(axis)
    for axis in [*AXES, *np.eye(3), *-np.eye(3)]
    for angle in (0.0, 1e-9, 1e-4, 0.999e-3, 1.001e-3, 0.3, 2.0, np.pi - 1e-3, np.pi - 1e-7)
]


def test_the_exponential_is_the_rotation():
    for r in VECTORS:
        assert np.allclose(exponential(r), Rotation.from_rotvec(r).as_matrix(), atol=1e-14)


def test_the_logarithm_leads_back():
    for r in VECTORS:
        assert np.allclose(logarithm(exponential(r)), r, atol=2e-9 if np.linalg.norm(r) > 3.0 else 1e-14)


def test_half_a_turn_has_a_logarithm():
    for axis in np.eye(3):
        R = 2.0 * np.outer(axis, axis) - np.eye(3)
        assert np.allclose(np.abs(logarithm(R)), np.pi * axis)


@pytest.mark.parametrize("angle", [0.0, 5e-4, 2e-3, 0.7, 3.0])
def test_the_jacobian_is_that_of_the_exponential(angle):
    for axis, rate in zip(AXES, AXES[::-1], strict=True):
        r = angle * axis / np.linalg.norm(axis)
        e = 1e-6
        slope = exponential(r).T @ (exponential(r + e * rate) - exponential(r - e * rate)) / (2 * e)
        spin = np.array([slope[2, 1], slope[0, 2], slope[1, 0]])
        assert np.allclose(jacobian(r) @ rate, spin, atol=1e-8)
        assert np.allclose(inverse_jacobian(r) @ jacobian(r), np.eye(3), atol=1e-12)
