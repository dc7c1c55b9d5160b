"""Conversion between lanes and the points of strand axes, which contact works on.

Flat, a point is a row of three numbers and strand s owns rows offsets[s]:offsets[s+1], as in the groom. In lanes the
components of a point lie a vector apart, and the strands of a block are interleaved.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.strands.layout import Layout

_NOWHERE = np.full(3, -0.0)
"""An origin that changes no number: the positive zero would change the sign of the negative one."""


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

    def gather(
        self,
        lanes: np.ndarray,
        out: np.ndarray | None = None,
        *,
        active: np.ndarray | None = None,
        origin: np.ndarray = _NOWHERE,
    ) -> np.ndarray:
        """Copy the values of active strands to the points of the groom, in place; return all of these.

        lanes   of particles, (rows, k, W), or of strands, (blocks, W), which all of their points get
        out     (P, k), k at most 3, or (P,); of bool: whether a value is not 0; by default new, float64
        active  nonzero for the strands to copy, (blocks, W); all by default
        origin  added to the values of particles, (3,)
        """
        if out is None:
            out = np.empty((self.offsets[-1], *lanes.shape[1:-1]))
        if active is None:
            active = np.ones(self.strands.shape, lanes.dtype)
        if lanes.ndim == 3:
            _gather(self, active, lanes, origin, out)
        else:
            _gather_strands(self, active, lanes, out)
        return out

    def scatter(self, points: np.ndarray, lanes: np.ndarray) -> None:
        """Copy the values of points to lanes, in place.

        points  (P, k), for particles, (rows, k, W), where those off the axis are unchanged; or (P,) bool, for
                strands, (blocks, W), which are 1 where a point is marked, else 0
        """
        copy = _scatter if points.ndim == 2 else _scatter_marks
        copy(self, points, lanes)


def axis_of(layout: Layout) -> Axis:
    """Return the axis of a layout; its arrays are shared."""
    shape = layout.shape
    return Axis(layout.first, layout.strands, layout.idle, layout.offsets, shape.clamped - 1, shape.stride)


@njit(cache=True, parallel=True)
def _gather(axis: Axis, active: np.ndarray, lanes: np.ndarray, origin: np.ndarray, out: np.ndarray) -> None:
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            # Threads write disjoint points: an idle lane repeats a strand of another lane.
            if active[block, lane] != 0.0 and not axis.idle[block, lane]:
                strand = axis.strands[block, lane]
                for n in range(axis.offsets[strand + 1] - axis.offsets[strand]):
                    row = axis.first[block] + axis.root + axis.stride * n
                    point = axis.offsets[strand] + n
                    for c in range(out.shape[1]):
                        out[point, c] = lanes[row, c, lane] + origin[c]


@njit(cache=True, parallel=True)
def _gather_strands(axis: Axis, active: np.ndarray, lanes: np.ndarray, out: np.ndarray) -> None:
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            if active[block, lane] != 0.0 and not axis.idle[block, lane]:
                strand = axis.strands[block, lane]
                for point in range(axis.offsets[strand], axis.offsets[strand + 1]):
                    out[point] = lanes[block, lane]


@njit(cache=True, parallel=True)
def _scatter(axis: Axis, points: np.ndarray, lanes: np.ndarray) -> None:
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
    masses = axis.gather(mass[:, None, :])
    if axis.stride == 2:
        before = axis._replace(root=axis.root - 1).gather(mass[:, None, :])
        before[axis.offsets[:-1]] = 0.0  # The particle before the root point is held.
        masses += 0.5 * before
        masses[:-1] += 0.5 * before[1:]
    return masses[:, 0]


@njit(cache=True, parallel=True)
def _scatter_marks(axis: Axis, marked: np.ndarray, lanes: np.ndarray) -> None:
    for block in prange(len(axis.first) - 1):
        for lane in range(axis.strands.shape[1]):
            strand = axis.strands[block, lane]
            lanes[block, lane] = 0.0
            for point in range(axis.offsets[strand], axis.offsets[strand + 1]):
                if marked[point]:
                    lanes[block, lane] = 1.0
