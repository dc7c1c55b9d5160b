"""Assignment of strands to lanes: strands of equal segment count fill blocks.

Conversion between lanes and the points of strand axes, which contact works on.

Flat, a point is a row of three numbers and strand s owns rows offsets[s]:offsets[s+1], as in the groom. In lanes the
components of a point lie a vector apart, and the strands of a block are interleaved.
"""
# pyright: reportCallIssue=false

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import DTypeLike

from hairpipe.geometry.simd import width


class Shape(NamedTuple):
    """Order of the particles of a strand in its rows.

    reach    number of following particles that a force couples to a particle
    clamped  number of particles at the root that the body holds; the last of them is m_0, the first point of the groom
    stride   rows from one particle on the axis to the next
    unknowns of a row of the system: 3, or 4 where the edge to the next particle has an angle
    before   number of particles before those that edges join: they define the orientation of the root
    after    number of particles after those: they define the orientation of a held tip
    """

    reach: int
    clamped: int
    stride: int
    unknowns: int = 3
    before: int = 0
    after: int = 0

    def count(self, segments: int) -> int:
        """Return the number of particles of a strand."""
        return self.stride * segments + self.clamped + self.after

    def segments(self, segments: int) -> np.ndarray:
        """Return the segment that each particle begins or lies in; those before the root count as in the first."""
        return np.clip((np.arange(self.count(segments)) - self.clamped + 1) // self.stride, 0, segments - 1)

    @property
    def axis(self) -> slice:
        """Indices of the points of the groom among the particles."""
        return slice(self.clamped - 1, -self.after or None, self.stride)


@dataclass(frozen=True, eq=False)
class Layout:
    """Blocks of strands with the same number of segments; the last block of a class repeats its last strand.

    offsets   of the groom's points, (strands+1,) int32
    strands   strand in every lane, (blocks, width) int64
    idle      lanes that only repeat a strand, (blocks, width) bool
    segments  of the strands of a block, (blocks,) int64
    first     rows (particles) of block b are first[b]:first[b+1], (blocks+1,) int64
    shape     order of the particles of a strand in its rows
    dtype     precision of the strands, float64 or float32
    """

    offsets: np.ndarray
    strands: np.ndarray
    idle: np.ndarray
    segments: np.ndarray
    first: np.ndarray
    shape: Shape
    dtype: np.dtype

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.segments)

    @property
    def width(self) -> int:
        """Strands in a block: lanes of the dtype that they are computed in."""
        return self.strands.shape[1]

    @property
    def particles(self) -> int:
        """Number of particles of all strands, without those of idle lanes."""
        return sum(map(self.shape.count, (np.diff(self.offsets) - 1).tolist()))

    def empty(self, *components: int, dtype: DTypeLike = None) -> np.ndarray:
        """Make room for values of all particles, (rows, *components, width), of another dtype where one is given."""
        return np.empty((self.first[-1], *components, self.width), dtype or self.dtype)

    def empty_blocks(self, *components: int) -> np.ndarray:
        """Make room for values of all strands, (blocks, *components, width)."""
        return np.empty((self.blocks, *components, self.width), self.dtype)

    def gather(self, lanes: np.ndarray, blocks: np.ndarray) -> np.ndarray:
        """Return the values of the strands of consecutive blocks of a class, in the order of their lanes; pure.

        lanes    of particles, (rows, ..., width), or of strands, (blocks, ..., width)
        returns  (strands, particles, ...), or (strands, 1, ...)
        """
        found = lanes[self._rows(lanes, blocks)]
        found = np.moveaxis(found.reshape(len(blocks), -1, *lanes.shape[1:]), -1, 1)
        return found.reshape(len(blocks) * self.width, *found.shape[2:])

    def scatter(self, values: np.ndarray, blocks: np.ndarray, lanes: np.ndarray) -> None:
        """Write the values of the strands of consecutive blocks of a class, as `gather` returns them, in place."""
        found = values.reshape(-1, self.width, *values.shape[1:])
        lanes[self._rows(lanes, blocks)] = np.moveaxis(found, 1, -1).reshape(-1, *values.shape[2:], self.width)

    def _rows(self, lanes: np.ndarray, blocks: np.ndarray) -> slice:
        """Return where the particles, or the strands, of consecutive blocks are."""
        if len(lanes) == self.blocks:
            return slice(blocks[0], blocks[-1] + 1)
        return slice(self.first[blocks[0]], self.first[blocks[-1] + 1])

    def classes(self) -> Iterator[np.ndarray]:
        """Iterate over the blocks of each segment count."""
        return (np.flatnonzero(self.segments == segments) for segments in np.unique(self.segments))

    def points(self, blocks: np.ndarray) -> np.ndarray:
        """Return where the points of the strands of a class are in the groom, (strands, segments+1)."""
        starts = self.offsets[self.strands[blocks].reshape(-1)]
        return starts[:, None] + np.arange(self.segments[blocks[0]] + 1)

    def axis(self, values: np.ndarray) -> np.ndarray:
        """Collect the axis particles (m_0 ... m_n) of every strand in the order of the groom.

        values   (rows, 3, width)
        returns  (points, 3), of the same dtype
        """
        collected = np.empty((self.offsets[-1], 3), values.dtype)
        for blocks in self.classes():
            collected[self.points(blocks)] = self.gather(values, blocks)[:, self.shape.axis]
        return collected


def lay_out(offsets: np.ndarray, shape: Shape, dtype: DTypeLike = np.float64) -> Layout:
    """Sort strands into blocks, keeping their order within a segment count."""
    lanes = width(dtype)
    counts = np.diff(offsets).astype(np.int64) - 1
    strands, idle, segments = [], [], []
    for count in np.unique(counts):
        members = np.flatnonzero(counts == count)
        missing = -len(members) % lanes
        strands.append(np.pad(members, (0, missing), mode="edge").reshape(-1, lanes))
        idle.append((np.arange(len(members) + missing) >= len(members)).reshape(-1, lanes))
        segments.append(np.full(len(strands[-1]), count))
    sizes = [shape.count(count) for count in np.concatenate(segments).tolist()]
    first = np.concatenate([[0], np.cumsum(sizes)])
    joined = (np.concatenate(parts) for parts in (strands, idle, segments))
    return Layout(offsets, *joined, first, shape, np.dtype(dtype))


def relaid(values: np.ndarray, here: Layout, there: Layout) -> np.ndarray:
    """Return what particles, (rows, ..., W), or strands, (blocks, ..., W), have in another layout of a groom; pure."""
    count = there.blocks if len(values) == here.blocks else there.first[-1]
    out = np.empty((count, *values.shape[1:-1], there.width), values.dtype)
    for blocks, others in zip(here.classes(), there.classes(), strict=True):
        strands = here.gather(values, blocks)
        repeated = np.minimum(np.arange(len(others) * there.width), len(strands) - 1)
        there.scatter(strands[repeated], others, out)
    return out


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
