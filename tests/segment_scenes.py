"""Scenes of segments, and what must be found in them by looking at every pair."""

import numpy as np
import pytest

STRANDS, POINTS = 26, 9
# Hair in a shell round a head, before and after a step of a shake of the head.
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


def offsets_of(strands=STRANDS, points=POINTS):
    return np.arange(strands + 1, dtype=np.int32) * points


def _to_segment(p, a, b):
    """Distances of points to segments."""
    u = b - a
    uu = (u * u).sum(-1)
    t = np.clip(((p - a) * u).sum(-1) / np.where(uu > 0, uu, 1), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * u, axis=-1)


def distances_of(points, i, j):
    """Distances of segments: the least of the four ends to the other one, and between the lines where those meet."""
    a, b, c, d = points[i], points[i + 1], points[j], points[j + 1]
    ends = [_to_segment(a, c, d), _to_segment(b, c, d), _to_segment(c, a, b), _to_segment(d, a, b)]
    u, v, w = b - a, d - c, a - c
    n = np.cross(u, v)
    nn = np.where((n * n).sum(-1) > 0, (n * n).sum(-1), np.inf)
    s, t = -(np.cross(w, v) * n).sum(-1) / nn, -(np.cross(w, u) * n).sum(-1) / nn
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    between = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=-1)
    return np.minimum(np.min(ends, axis=0), np.where(inside, between, np.inf))


def every_pair(offsets):
    """All pairs of segments that share no point."""
    is_segment = np.ones(offsets[-1], bool)
    is_segment[offsets[1:] - 1] = False
    segments = np.flatnonzero(is_segment)
    i, j = np.triu_indices(len(segments), 1)
    i, j = segments[i], segments[j]
    apart = j - i > 1
    return i[apart], j[apart]


def make_scenes():
    """Name, positions, reach."""
    rng = np.random.default_rng(4)
    cloud = rng.random((STRANDS * POINTS, 3))
    hair = 0.05 * rng.normal(size=(STRANDS, POINTS, 3)).cumsum(axis=1) + rng.random((STRANDS, 1, 3))
    scenes = {"cloud": (cloud, 0.1), "hair": (hair.reshape(-1, 3), 0.08)}
    scenes["on a plane grid"] = np.round(4 * cloud) / 4 * [1, 1, 0], 0.25
    scenes["coincident"] = np.round(3 * cloud) / 3, 0.0
    scenes["one point"] = np.full_like(cloud, 0.3), 0.0
    without_length = cloud.copy()
    without_length[::2] = without_length[1::2]
    scenes["without length"] = without_length, 0.15
    parallel = np.tile(np.linspace(0, 1, POINTS), STRANDS)[:, None] * [0.3, 0.5, 0.7]
    across = rng.random((STRANDS, 1, 3)) * 0.2 + 1e-9 * rng.normal(size=(STRANDS, POINTS, 3))
    scenes["parallel"] = parallel + across.reshape(-1, 3), 0.05
    long = cloud.copy()
    long[[5, 200]] += [[0, 30, 0], [-50, 1, 0]]
    scenes["very long"] = long, 0.1
    flung = cloud.copy()
    flung[:POINTS] += 1e3
    flung[2 * POINTS : 3 * POINTS] -= [1e6, 0, 0]
    scenes["far-flung"] = flung, 0.1
    far = 1e-5 * cloud
    far[100:] += 1e3
    scenes["small and far"] = far, 1e-6
    return scenes


SCENES = make_scenes()


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


@pytest.fixture(params=SCENES, ids=str)
def scene(request):
    """Give positions, offsets and a reach."""
    points, reach = SCENES[request.param]
    return points, offsets_of(), reach


@pytest.fixture(scope="session")
def hair():
    """Give positions before and after a step, and offsets, of hair that fills several chunks of every kernel."""
    return tangle(800, 8, 1)


@pytest.fixture(scope="session")
def few_hairs():
    """Give the same of hair that is soon looked through."""
    return tangle(60, 10, 3)
