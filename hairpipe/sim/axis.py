"""Conversion between lanes and the points of strand axes, which contact works on.

Flat, a point is a row of three numbers and strand s owns rows offsets[s]:offsets[s+1], as in the groom. In lanes the
components of a point lie a vector apart, and the strands of a block are interleaved.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.sim.layout import Layout


class Axis(NamedTuple):
    """Rows and lanes of the groom's points among the particles.

    first    rows of block b are first[b]:first[b+1], (blocks+1,) int64
    strands  strand in every lane, (blocks, W) int64
    idle     lanes that only repeat a strand, (blocks, W) bool
    offsets  of the groom's points, (strands+1,) int32
    root     row of the first point in a block
    stride   rows from one point to the next
    """

    first: np.ndarray
    strands: np.ndarray
    idle: np.ndarray
    offsets: np.ndarray
    root: int
    stride: int


def axis_of(layout: Layout) -> Axis:
    """Return the axis of a layout; its arrays are shared."""
    shape = layout.shape
    return Axis(layout.first, layout.strands, layout.idle, layout.offsets, shape.clamped - 1, shape.stride)


@njit(cache=True, parallel=True)
def gather(axis: Axis, active: np.ndarray, lanes: np.ndarray, out: np.ndarray) -> None:
    """Copy values on the axes of active strands, (rows, k, W), to the points of the groom, (P, k), in place.

    active  nonzero for strands to copy, (blocks, W)
    """
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            # Threads write disjoint points: an idle lane repeats a strand of another lane.
            if active[block, lane] != 0.0 and not axis.idle[block, lane]:
                strand = axis.strands[block, lane]
                for n in range(axis.offsets[strand + 1] - axis.offsets[strand]):
                    row = axis.first[block] + axis.root + axis.stride * n
                    point = axis.offsets[strand] + n
                    for c in range(out.shape[1]):
                        out[point, c] = lanes[row, c, lane]


@njit(cache=True, parallel=True)
def scatter(axis: Axis, points: np.ndarray, lanes: np.ndarray) -> None:
    """Write values of points, (P, k), to lanes, (rows, k, W), in place.

    Rows off the axis are unchanged.
    """
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):  # Idle lanes must stay copies, as `any_lane` looks at them, too.
            strand = axis.strands[block, lane]
            for n in range(axis.offsets[strand + 1] - axis.offsets[strand]):
                row = axis.first[block] + axis.root + axis.stride * n
                point = axis.offsets[strand] + n
                for c in range(points.shape[1]):
                    lanes[row, c, lane] = points[point, c]


@njit(cache=True, parallel=True)
def follow(axis: Axis, change: np.ndarray, times: float, lanes: np.ndarray) -> None:
    """Add changes of points, (P, 3), times a factor, to lanes, (rows, 3, W), in place.

    A perturbed particle moves with the mean of its two neighbours on the axis. Held points are unchanged.
    """
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            strand = axis.strands[block, lane]
            for n in range(1, axis.offsets[strand + 1] - axis.offsets[strand]):
                row = axis.first[block] + axis.root + axis.stride * n
                point = axis.offsets[strand] + n
                for c in range(3):
                    here = times * change[point, c]
                    before = times * change[point - 1, c] if n > 1 else 0.0  # Point 0 is held, whatever its change is.
                    lanes[row, c, lane] += here
                    if axis.stride == 2 and (here != 0.0 or before != 0.0):
                        lanes[row - 1, c, lane] += 0.5 * (here + before)


def following_masses(axis: Axis, mass: np.ndarray) -> np.ndarray:
    """Return the mass that moves with each point when `follow` changes that point alone [kg], (P,); pure.

    mass  of particles [kg], (rows, W)
    """
    everyone = np.ones(axis.strands.shape, mass.dtype)
    masses = np.empty((axis.offsets[-1], 1))
    gather(axis, everyone, mass[:, None, :], masses)
    if axis.stride == 2:
        before = np.empty_like(masses)
        gather(axis._replace(root=axis.root - 1), everyone, mass[:, None, :], before)
        before[axis.offsets[:-1]] = 0.0  # The particle before the root point is held.
        masses += 0.5 * before
        masses[:-1] += 0.5 * before[1:]
    return masses[:, 0]


@njit(cache=True, parallel=True)
def lanes_with(axis: Axis, marked: np.ndarray, lanes: np.ndarray) -> None:
    """Set lanes, (blocks, W), to 1 for strands with a marked point, (P,) bool, to 0 for the others, in place."""
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            strand = axis.strands[block, lane]
            lanes[block, lane] = 0.0
            for point in range(axis.offsets[strand], axis.offsets[strand + 1]):
                if marked[point]:
                    lanes[block, lane] = 1.0


@njit(cache=True, parallel=True)
def spread(axis: Axis, lanes: np.ndarray, out: np.ndarray) -> None:
    """Write values of strands, (blocks, W), to their points, (P,), in place."""
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            strand = axis.strands[block, lane]
            out[axis.offsets[strand] : axis.offsets[strand + 1]] = lanes[block, lane]


@njit(cache=True, parallel=True)
def points_of(axis: Axis, lanes: np.ndarray, marked: np.ndarray) -> None:
    """Mark the points, (P,) bool, of strands with a number that is not 0, (blocks, W), and no others, in place."""
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            strand = axis.strands[block, lane]
            for point in range(axis.offsets[strand], axis.offsets[strand + 1]):
                marked[point] = lanes[block, lane] != 0.0
