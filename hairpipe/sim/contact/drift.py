"""What neighbouring hair has in common in its motion, and how far a segment departs from that.

A smooth field w over space, and its Lipschitz constant L: where two points p, q that move by u in half a step come
within reach of each other, they are at half time no farther apart than

    |p - q| <= reach + |u_p - w_p| + |u_q - w_q| + L |p - q|,   so   |p - q| <= (reach + e_p + e_q) / (1 - L).

Any w is right, and the better it follows the motion the less has to be searched. Ours has its values at the nodes of
a coarse lattice that comes round at its ends, the mean of the motion near each, smoothed until L is small.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.body.vectors import Vector, length, minus, mix
from hairpipe.sim.contact.grid import in_cells
from hairpipe.sim.contact.pieces import Pieces, piece, pieces_of

STEEPEST = 0.05
"""Lipschitz constant that the field may have."""
_NODES = 12
_MARGIN = 2
_SPREADINGS = 4
_SMOOTHINGS = 40
_SAMPLE = 16384
_CHUNK = 4096
_OUTLYING = 3.0
"""Speed over that of three quarters, all relative to the median."""


class Drift(NamedTuple):
    """A field of displacements in half a step.

    nodes    its values [m], (nx, ny, nz, 3)
    corner   of the lattice [m], (3,)
    spacing  of the nodes [m]
    steep    its Lipschitz constant
    """

    nodes: np.ndarray
    corner: np.ndarray
    spacing: float
    steep: float


def find_drift(middle: np.ndarray, half: np.ndarray) -> Drift:
    """Average displacements in half a step, half, of points that are at half time in middle, (P, 3) [m]; pure.

    Few that are far off, or far faster than most, do not count.
    """
    every = slice(None, None, max(1, len(middle) // _SAMPLE))
    middle, half = middle[every], half[every]
    low, high = np.quantile(middle, [0.05, 0.95], axis=0) if len(middle) else np.zeros((2, 3))
    overall = np.median(half, axis=0) if len(half) else np.zeros(3)
    speeds = np.linalg.norm(half - overall, axis=1)
    most = _OUTLYING * np.quantile(speeds, 0.75) if len(half) else 0.0
    half = overall + (half - overall) * np.minimum(1.0, most / np.maximum(speeds, 1e-300))[:, None]
    spacing = max(float((high - low).max()) / _NODES, 1e-9)
    shape = np.ceil((high - low) / spacing).astype(np.int64) + 1 + 2 * _MARGIN
    corner = low - _MARGIN * spacing
    sums, counts = np.zeros((*shape, 3)), np.zeros(shape)
    _gather(middle, half, corner, spacing, sums, counts)
    for _ in range(_SPREADINGS):
        sums, counts = _spread(sums, counts)
    nodes = np.where(counts[..., None] > 0.0, sums / np.maximum(counts, 1e-300)[..., None], overall)
    steep = _steepness(nodes, spacing)
    for _ in range(_SMOOTHINGS):
        if steep > STEEPEST:
            nodes = _smooth(nodes)
            steep = _steepness(nodes, spacing)
    if steep > STEEPEST:
        nodes, steep = overall + (nodes - overall) * (STEEPEST / steep), STEEPEST
    return Drift(nodes, corner, spacing, steep * (1.0 + 1e-9))


@njit(cache=True)
def _steepness(nodes: np.ndarray, spacing: float) -> float:
    """Bound the Lipschitz constant of trilinear interpolation by the steepest edges along each axis."""
    nx, ny, nz, _ = nodes.shape
    along_x, along_y, along_z = 0.0, 0.0, 0.0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                x, y, z = 0.0, 0.0, 0.0
                for c in range(3):
                    here = nodes[i, j, k, c]
                    x += (nodes[(i + 1) % nx, j, k, c] - here) ** 2
                    y += (nodes[i, (j + 1) % ny, k, c] - here) ** 2
                    z += (nodes[i, j, (k + 1) % nz, c] - here) ** 2
                along_x, along_y, along_z = max(along_x, x), max(along_y, y), max(along_z, z)
    return np.sqrt(along_x + along_y + along_z) / spacing


@njit(cache=True)
def _spread(sums: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give nodes that have nothing near what their six neighbours have."""
    nx, ny, nz = counts.shape
    more, weights = sums.copy(), counts.copy()
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if counts[i, j, k] == 0.0:
                    around = ((i - 1, j, k), ((i + 1) % nx, j, k), (i, j - 1, k))
                    for x, y, z in (*around, (i, (j + 1) % ny, k), (i, j, k - 1), (i, j, (k + 1) % nz)):
                        weights[i, j, k] += counts[x, y, z]
                        for c in range(3):
                            more[i, j, k, c] += sums[x, y, z, c]
    return more, weights


@njit(cache=True)
def _smooth(nodes: np.ndarray) -> np.ndarray:
    """Average every node with its six neighbours."""
    nx, ny, nz, _ = nodes.shape
    smoother = np.empty_like(nodes)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                for c in range(3):
                    x = nodes[(i + 1) % nx, j, k, c] + nodes[i - 1, j, k, c]
                    y = nodes[i, (j + 1) % ny, k, c] + nodes[i, j - 1, k, c]
                    z = nodes[i, j, (k + 1) % nz, c] + nodes[i, j, k - 1, c]
                    smoother[i, j, k, c] = (2.0 * nodes[i, j, k, c] + x + y + z) / 8.0
    return smoother


@njit(cache=True)
def _gather(middle, half, corner, spacing, sums, counts):  # noqa: ANN001, ANN202
    for k in range(len(middle)):
        x = round((middle[k, 0] - corner[0]) / spacing) % counts.shape[0]
        y = round((middle[k, 1] - corner[1]) / spacing) % counts.shape[1]
        z = round((middle[k, 2] - corner[2]) / spacing) % counts.shape[2]
        counts[x, y, z] += 1.0
        for c in range(3):
            sums[x, y, z, c] += half[k, c]


def departures(drift: Drift, middle: np.ndarray, half: np.ndarray, pieces: Pieces) -> np.ndarray:
    """Bound by how much any place of the pieces departs from the field in half a step [m], (E,); pure."""
    found = np.empty(len(pieces.segments))
    _bound(drift, middle, half, pieces.segments, pieces.numbers, pieces.cut, found)
    return found


@njit(cache=True, parallel=True)
def _bound(drift, middle, half, segments, numbers, cut, found):  # noqa: ANN001, ANN202
    """Along a piece displacement is linear, and the field departs from that by at most L length / 2."""
    for chunk in prange(-(-len(found) // _CHUNK)):
        begin = np.int64(chunk) * _CHUNK
        ended, last = 0.0, -2  # departure at the end of the piece before, and its segment
        for e in range(begin, min(begin + _CHUNK, len(found))):
            i = segments[e]
            count = pieces_of(middle, i, cut)
            a, b = piece(middle, i, numbers[e], count)
            u, v = piece(half, i, numbers[e], count)
            begun = ended if i == last + 1 and numbers[e] == 0 else _departure(drift, a, u)
            ended, last = _departure(drift, b, v), i
            found[e] = max(begun, ended) + 0.5 * drift.steep * length(minus(b, a))


@inlined
def _departure(drift: Drift, x: Vector, u: Vector) -> float:
    """Return how far a displacement u at x departs from the field."""
    return length(minus(u, _interpolate(drift, x)))


@inlined
def _interpolate(drift: Drift, x: Vector) -> Vector:
    """Return the field at x."""
    nx, ny, nz = drift.nodes.shape[0], drift.nodes.shape[1], drift.nodes.shape[2]
    a, b, c = in_cells(x, drift.corner, drift.spacing)
    i, j, k = np.floor(a), np.floor(b), np.floor(c)
    a, b, c = a - i, b - j, c - k
    i0, j0, k0 = int(i) % nx, int(j) % ny, int(k) % nz
    i1, j1, k1 = (i0 + 1) % nx, (j0 + 1) % ny, (k0 + 1) % nz
    near = mix(_along_z(drift, i0, j0, k0, k1, c), _along_z(drift, i0, j1, k0, k1, c), b)
    far = mix(_along_z(drift, i1, j0, k0, k1, c), _along_z(drift, i1, j1, k0, k1, c), b)
    return mix(near, far, a)


@inlined
def _along_z(drift: Drift, i: int, j: int, k0: int, k1: int, c: float) -> Vector:
    nodes = drift.nodes
    low = nodes[i, j, k0, 0], nodes[i, j, k0, 1], nodes[i, j, k0, 2]
    high = nodes[i, j, k1, 0], nodes[i, j, k1, 1], nodes[i, j, k1, 2]
    return mix(low, high, c)
