"""Scenes of segments, and what must be found in them by looking at every pair."""

import numpy as np
import pytest

from hairpipe.bench.tangle import tangle

STRANDS, POINTS = 26, 9


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


@pytest.fixture(params=SCENES, ids=str)
def scene(request):
    """Give positions, offsets and a reach."""
    points, reach = SCENES[request.param]
    return points, offsets_of(), reach


@pytest.fixture(scope="session")
def hair():
    """Give positions before and after a step, and offsets, of hair that fills several chunks of every kernel."""
    return tangle(800, 8, 1)


@pytest.fixture
def brute():
    """Give the functions that list all pairs, and their distances."""
    return every_pair, distances_of
