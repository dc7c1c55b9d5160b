"""Hair to search for contacts: strands in a shell round a head, before and after a step of a shake of the head."""

import numpy as np

RADIUS, SHELL = 0.105, 0.025
"""Of the head; thickness of the hair on it [m]."""
LENGTH = 3e-3
"""Of a segment [m]."""
COMBED, DISORDER = np.array([0.6, 0.0, 0.8]), 0.3
"""Axis that strands run round, and how much each has a direction of its own."""
TURN, FREQUENCY, STEP = np.radians(60.0), 1.5, 1 / 240
"""Yaw [rad], so often a second [Hz]; length of a step [s]."""
TURBULENCE, SPREAD = 0.04, 0.9
"""Typical speed of a strand by itself [m/s], and the deviation of its logarithm among strands."""


def tangle(strands: int, segments: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions before and after a step [m], (P, 3) each, and the offsets of the strands, (strands + 1,) int32.

    Strands wander through the shell, all over the sphere; the head turns, the hair lags behind the more the farther out
    it is, every strand a little on its own. The same for the same seed.
    """
    rng = np.random.default_rng(seed)
    points = segments + 1
    before = _wander(rng, strands, points)
    axis = np.array([0.0, 1.0, 0.0])
    speed = TURN * 2.0 * np.pi * FREQUENCY
    depth = np.linalg.norm(before, axis=2, keepdims=True) - RADIUS
    carried = np.cross(axis, before) * speed * (1.0 - 0.8 * np.clip(depth / SHELL, 0.0, 1.0))
    own = np.cumsum(rng.normal(size=(strands, points, 3)), axis=1) / np.sqrt(np.arange(1, points + 1))[None, :, None]
    speeds = TURBULENCE * rng.lognormal(0.0, SPREAD, (strands, 1, 1)) * np.linspace(0.2, 1.5, points)[:, None]
    after = before + STEP * (carried + speeds * own)
    offsets = np.arange(strands + 1, dtype=np.int32) * points
    return before.reshape(-1, 3), after.reshape(-1, 3), offsets


def _wander(rng: np.random.Generator, strands: int, points: int) -> np.ndarray:
    """Let strands start anywhere in the shell and run along it, bending a little, kept inside, (strands, points, 3)."""
    place = _directions(rng, strands) * (RADIUS + SHELL * rng.random((strands, 1)))
    along = np.cross(place, COMBED) / RADIUS + DISORDER * _directions(rng, strands)
    path = np.empty((strands, points, 3))
    for k in range(points):
        path[:, k] = place
        out = place / np.linalg.norm(place, axis=1, keepdims=True)
        depth = (np.linalg.norm(place, axis=1, keepdims=True) - RADIUS) / SHELL
        radial = np.sum(along * out, axis=1, keepdims=True)
        along = along + 0.05 * rng.normal(size=along.shape) - out * (radial + 0.5 * (depth - rng.random((strands, 1))))
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        place = place + LENGTH * along
    return path


def _directions(rng: np.random.Generator, count: int) -> np.ndarray:
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)
