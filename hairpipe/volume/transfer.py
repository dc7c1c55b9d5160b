"""Mass and momentum of strands on a dense grid of nodes, and back: P2G and its transpose, G2P.

With the weights w_gs of sample s at node g and a_si of point i in it, whose mass is spread evenly over its samples,

    B_gi = m_i sum_s w_gs a_si / A_i
    M_g = sum_i B_gi,   V_g = sum_i B_gi v_i / M_g,   V(i) = sum_g B_gi V_g / m_i

Momentum on the grid equals momentum on the strands: sum_i m_i V(i) = sum_g M_g V_g, exactly. The weights w_gs
are trilinear.

Points of strands lie farther apart than the nodes of a grid: splatting them alone leaves holes. A segment of length L
is cut into n = floor(L / h) + 1 pieces; a sample lies in the middle of each, at a share t = (q + 1/2) / n of the way
from its first point, to which it belongs by 1 - t, and by t to the second. The samples of point i sum up to

    A_i = sum_s a_si = (n_before + n_after) / 2

Samples are sorted by slabs of planes of nodes, those of a slab in the order of strands. A slab is added to by one
thread, even slabs before odd ones, since the last plane of a slab is the first one of the next: sums do not depend on
the number of threads. Sorting samples by cells, too, costs what it saves.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.trilinear import voxel_at, weight_of

MOST_NODES = 1 << 24
"""Maximum number of nodes of a grid: 0.5 GB."""
SLAB = 4
"""Planes of nodes in a slab, two at least."""
_CHUNK = 128  # strands that are sorted, or collected, together


class StrandSamples(NamedTuple):
    """Samples of strands and the grid around them.

    points    [m], (P, 3); offsets  of strands, (S+1,) int32
    low       of the first node, in cells, (3,); cell  [m]
    counts    of nodes, (3,) int64
    pieces    of the segment after each point, (P,) int32; 0 for the last ones, and for omitted strands
    segments  first point of the segment of every sample, slab by slab, (n,) int32; places  its piece, (n,) int32
    slabs     samples of slab s are slabs[s]:slabs[s+1], int64
    sums      A_i of every point, (P,); 0 for omitted strands
    """

    points: np.ndarray
    offsets: np.ndarray
    low: np.ndarray
    cell: float
    counts: np.ndarray
    pieces: np.ndarray
    segments: np.ndarray
    places: np.ndarray
    slabs: np.ndarray
    sums: np.ndarray


def sample_strands(points: np.ndarray, offsets: np.ndarray, reach: np.ndarray, cell: float) -> StrandSamples | None:
    """Sample strands; None where none is valid.

    points   [m], (P, 3) float64; offsets  of strands, (S+1,) int32
    reach    largest distance of the points of a strand from its root [m], (S,): a strand with a farther point, or one
             that is not finite, is omitted, so that it does not enlarge the grid
    cell     spacing of nodes [m]

    Raises BadInput where the grid would have more than MOST_NODES.
    """
    chunks = -(-(len(offsets) - 1) // _CHUNK)
    pieces = np.zeros(len(points), np.int32)
    bounds = np.empty((chunks, 2, 3))
    _cut(points, offsets, reach, cell, pieces, bounds)
    least = bounds[:, 0].min(axis=0)
    greatest = bounds[:, 1].max(axis=0)
    if not (least <= greatest).all():
        return None
    low = np.floor(least / cell)
    counts = np.floor(greatest / cell) - low + 2.0  # as floats: numbers may be too large for integers
    if np.prod(counts) > MOST_NODES:
        fits = cell * (np.prod(counts) / MOST_NODES) ** (1 / 3)
        sizes = " x ".join(f"{size:.2g}" for size in greatest - least)
        message = f"a grid of {cell:g} m around hair of {sizes} m has {np.prod(counts):.2g} nodes"
        raise BadInput(message, where="volume.cell", right=f"at least {1.1 * fits:.2g} m")
    planes = int(counts[0])
    found = np.zeros((chunks, -(-(planes - 1) // SLAB)), np.int64)
    across = float(low[0]), 1.0 / cell, planes
    _count(points, offsets, pieces, across, found)
    ends = np.cumsum(found.T.ravel()).reshape(found.T.shape).T
    total = int(ends[-1, -1])
    starts = np.ascontiguousarray(ends - found)
    segments, places = np.empty(total, np.int32), np.empty(total, np.int32)
    _sort(points, offsets, pieces, across, starts, segments, places)
    slabs = np.append(ends[0] - found[0], total)
    before = np.roll(pieces, 1)  # the last of a strand has none
    numbers = counts.astype(np.int64)
    return StrandSamples(points, offsets, low, cell, numbers, pieces, segments, places, slabs, 0.5 * (before + pieces))


@njit(cache=True, parallel=True, error_model="numpy")
def _cut(points, offsets, reach, cell, pieces, bounds):
    """Count the pieces of segments, and bound valid strands, chunk by chunk, (chunks, 2, 3) [m]."""
    for chunk in prange(len(bounds)):
        bounds[chunk, 0], bounds[chunk, 1] = np.inf, -np.inf
        for strand in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(offsets) - 1)):
            begin = offsets[strand]
            end = offsets[strand + 1]
            sound = True
            for k in range(begin, end):
                sound = (
                    sound and _squared(points, begin, k) <= reach[strand] * reach[strand]
                )  # nothing is less than NaN
            for k in range(begin, end if sound else begin):
                for c in range(3):
                    bounds[chunk, 0, c] = min(bounds[chunk, 0, c], points[k, c])
                    bounds[chunk, 1, c] = max(bounds[chunk, 1, c], points[k, c])
                if k + 1 < end:
                    pieces[k] = int(np.sqrt(_squared(points, k, k + 1)) / cell) + 1


@inlined
def _squared(points, k, m):
    x, y, z = points[m, 0] - points[k, 0], points[m, 1] - points[k, 1], points[m, 2] - points[k, 2]
    return x * x + y * y + z * z


@inlined
def share_of(place: int, pieces: int) -> float:
    """Return the share t of the way along a segment at which a sample lies."""
    return (place + 0.5) / pieces


@inlined
def cells_of(samples, k, t, inverse):
    """Return the coordinates of a sample at share t of the segment from point k, in cells from the first node.

    inverse  1 over a cell [1/m]
    """
    points, low = samples.points, samples.low
    return (
        (points[k, 0] + t * (points[k + 1, 0] - points[k, 0])) * inverse - low[0],
        (points[k, 1] + t * (points[k + 1, 1] - points[k, 1])) * inverse - low[1],
        (points[k, 2] + t * (points[k + 1, 2] - points[k, 2])) * inverse - low[2],
    )


@inlined
def _slab_of(points, k, t, across):
    low, inverse, planes = across
    u = (points[k, 0] + t * (points[k + 1, 0] - points[k, 0])) * inverse - low
    return min(int(max(u, 0.0)), planes - 2) // SLAB  # Rounding may put a sample just outside of the grid.


@njit(cache=True, parallel=True, error_model="numpy")
def _count(points, offsets, pieces, across, found):
    """Count the samples of every chunk of strands in every slab, (chunks, slabs), in place."""
    for chunk in prange(len(found)):
        for k in range(offsets[chunk * _CHUNK], offsets[min((chunk + 1) * _CHUNK, len(offsets) - 1)]):
            for place in range(pieces[k]):
                found[chunk, _slab_of(points, k, share_of(place, pieces[k]), across)] += 1


@njit(cache=True, parallel=True, error_model="numpy")
def _sort(points, offsets, pieces, across, starts, segments, places):
    """List samples slab by slab, in place; starts (chunks, slabs) moves along."""
    for chunk in prange(len(starts)):
        for k in range(offsets[chunk * _CHUNK], offsets[min((chunk + 1) * _CHUNK, len(offsets) - 1)]):
            for place in range(pieces[k]):
                slab = _slab_of(points, k, share_of(place, pieces[k]), across)
                at = starts[chunk, slab]  # Each chunk has places of its own in a slab: samples stay in strand order.
                segments[at] = k
                places[at] = place
                starts[chunk, slab] = at + 1


def deposit(samples: StrandSamples, masses: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return mass [kg] and momentum [kg m/s] of strands at the nodes, (nx, ny, nz, 4).

    masses  of points, finite [kg], (P,); velocities  [m/s], (P, 3)
    """
    own = np.divide(masses, samples.sums, out=np.zeros(len(masses)), where=samples.sums > 0.0)
    amounts = np.column_stack([own, own[:, None] * velocities])
    grid = np.zeros((*samples.counts, 4))
    for parity in range(2):
        _deposit(samples, amounts, parity, grid)
    return grid


@njit(cache=True, parallel=True, error_model="numpy")
def _deposit(samples, amounts, parity, grid):
    """Splat the samples of every second slab, with mass and momentum of points per piece, (P, 4), to the nodes."""
    slabs = samples.slabs
    inverse = 1.0 / samples.cell
    # Slabs of one parity share no node; in each, samples come in the order of strands: sums have one order.
    for n in prange((len(slabs) - parity) // 2):
        slab = 2 * n + parity
        for at in range(slabs[slab], slabs[slab + 1]):
            k = samples.segments[at]
            t = share_of(samples.places[at], samples.pieces[k])
            row = _mean(amounts, k, t, 0), _mean(amounts, k, t, 1), _mean(amounts, k, t, 2), _mean(amounts, k, t, 3)
            u, v, w = cells_of(samples, k, t, inverse)
            voxel = voxel_at(grid, u, v, w)
            for a in range(2):
                for b in range(2):
                    for c in range(2):
                        weight = weight_of(voxel, a, b, c)
                        for d in range(4):
                            grid[voxel.i + a, voxel.j + b, voxel.k + c, d] += weight * row[d]


@inlined
def _mean(amounts, k, t, d):
    return amounts[k, d] + t * (amounts[k + 1, d] - amounts[k, d])


@njit(cache=True, parallel=True, error_model="numpy")
def collect(samples: StrandSamples, field: np.ndarray) -> np.ndarray:
    """Return the vectors of a field of nodes, (nx, ny, nz, 3), at points of strands, (P, 3); 0 of those left out."""
    found = np.empty((len(samples.points), 3))
    offsets = samples.offsets
    pieces = samples.pieces
    inverse = 1.0 / samples.cell
    strands = len(offsets) - 1
    for chunk in prange((strands + _CHUNK - 1) // _CHUNK):
        begin = offsets[chunk * _CHUNK]  # Whole strands, so that no point is written by two threads.
        end = offsets[min((chunk + 1) * _CHUNK, strands)]
        found[begin:end] = 0.0
        for k in range(begin, end):
            for place in range(pieces[k]):
                t = share_of(place, pieces[k])
                u, v, w = cells_of(samples, k, t, inverse)
                vector = _sample_vector(field, voxel_at(field, u, v, w))
                for c in range(3):
                    found[k, c] += (1.0 - t) * vector[c]
                    found[k + 1, c] += t * vector[c]
        for k in range(begin, end):
            if samples.sums[k] > 0.0:
                for c in range(3):
                    found[k, c] /= samples.sums[k]
    return found


@inlined
def _sample_vector(grid, at):
    x, y, z = 0.0, 0.0, 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = weight_of(at, a, b, c)
                i, j, k = at.i + a, at.j + b, at.k + c
                x += weight * grid[i, j, k, 0]
                y += weight * grid[i, j, k, 1]
                z += weight * grid[i, j, k, 2]
    return x, y, z


@njit(cache=True, parallel=True, error_model="numpy")
def mean_velocities(grid: np.ndarray, out: np.ndarray) -> None:
    """Write momentum over mass of nodes, (nx, ny, nz, 4), to out, (nx, ny, nz, 3) [m/s], in place; 0 without mass."""
    nodes = grid.reshape(-1, 4)
    vectors = out.reshape(-1, 3)
    for k in prange(len(nodes)):
        for c in range(3):
            vectors[k, c] = nodes[k, c + 1] / nodes[k, 0] if nodes[k, 0] > 0.0 else 0.0
