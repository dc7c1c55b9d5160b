"""Assignment of strands to lanes: strands of equal segment count fill blocks."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
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
