"""Rigid transforms and frames, column vectors."""

import numpy as np

Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Takes Z up, face towards -Y, to Y up, face towards +Z."""

PARALLEL = 0.99
"""Cosine from which a direction counts as that of +Y."""


def frame_along(ahead: np.ndarray) -> np.ndarray:
    """Return a frame around a unit vector, (3, 3): columns up, sideways, ahead, right-handed. Pure."""
    up = np.array((0.0, 0.0, 1.0) if abs(ahead[1]) > PARALLEL else (0.0, 1.0, 0.0))
    up -= (up @ ahead) * ahead
    up /= np.linalg.norm(up)
    return np.column_stack([up, np.cross(ahead, up), ahead])


def invert(transforms: np.ndarray) -> np.ndarray:
    """Return the inverses of rotations with translations (..., 4, 4). Pure."""
    result = np.zeros_like(transforms)
    result[..., :3, :3] = np.swapaxes(transforms[..., :3, :3], -1, -2)
    result[..., :3, 3] = -np.einsum("...ji,...j->...i", transforms[..., :3, :3], transforms[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result
