"""Rigid transforms, column vectors."""

import numpy as np

Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Takes Z up, face towards -Y, to Y up, face towards +Z."""


def invert(transforms: np.ndarray) -> np.ndarray:
    """Return the inverses of rotations with translations (..., 4, 4). Pure."""
    result = np.zeros_like(transforms)
    result[..., :3, :3] = np.swapaxes(transforms[..., :3, :3], -1, -2)
    result[..., :3, 3] = -np.einsum("...ji,...j->...i", transforms[..., :3, :3], transforms[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result
