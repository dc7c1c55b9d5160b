"""Assignment of strands to lanes: strands of equal segment count fill blocks."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from hairpipe.kernels.simd import width


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

    def fill(self, target: np.ndarray, blocks: np.ndarray, values: np.ndarray) -> None:
        """Write values of the particles of consecutive blocks, (lanes, particles, ...), into their rows, in place."""
        lanes = values.reshape(-1, self.width, *values.shape[1:])
        rows = slice(self.first[blocks[0]], self.first[blocks[-1] + 1])
        target[rows] = np.moveaxis(lanes, 1, -1).reshape(-1, *values.shape[2:], self.width)

    def fill_blocks(self, target: np.ndarray, blocks: np.ndarray, values: np.ndarray) -> None:
        """Write values of the strands of blocks, (components, lanes), into theirs, in place."""
        target[blocks] = values.reshape(-1, len(blocks), self.width).transpose(1, 0, 2)

    def classes(self, points: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Blocks of each segment count, and the points of their strands lane by lane, (lanes, segments+1, 3)."""
        for segments in np.unique(self.segments):
            blocks = np.flatnonzero(self.segments == segments)
            starts = self.offsets[self.strands[blocks].reshape(-1)]
            yield blocks, points[starts[:, None] + np.arange(segments + 1)]

    def axis(self, values: np.ndarray) -> np.ndarray:
        """Collect the axis particles (m_0 ... m_n) of every strand in the order of the groom.

        values   (rows, 3, width)
        returns  (points, 3), of the same dtype
        """
        collected = np.empty((self.offsets[-1], 3), values.dtype)
        for segments in np.unique(self.segments):
            blocks = np.flatnonzero(self.segments == segments)
            rows = values[self.first[blocks[0]] : self.first[blocks[-1] + 1]]
            axis = rows.reshape(len(blocks), -1, 3, self.width)[:, self.shape.axis].transpose(0, 3, 1, 2)
            starts = self.offsets[self.strands[blocks]]
            collected[starts[:, :, None] + np.arange(segments + 1)] = axis
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
    of_rows = len(values) != here.blocks
    counts = [layout.first[-1] if of_rows else layout.blocks for layout in (here, there)]
    out = np.empty((counts[1], *values.shape[1:-1], there.width), values.dtype)
    for segments in np.unique(here.segments):
        rows, target = (_rows_of_class(layout, segments, of_rows) for layout in (here, there))
        blocks, others = (np.count_nonzero(layout.segments == segments) for layout in (here, there))
        lanes = values[rows].reshape(blocks, -1, *values.shape[1:])
        lanes = np.moveaxis(lanes, -1, 1).reshape(blocks * here.width, *lanes.shape[1:-1])
        lanes = lanes[np.minimum(np.arange(others * there.width), len(lanes) - 1)]
        lanes = np.moveaxis(lanes.reshape(others, there.width, *lanes.shape[1:]), 1, -1)
        out[target] = lanes.reshape(-1, *out.shape[1:])
    return out


def _rows_of_class(layout: Layout, segments: int, of_rows: bool) -> slice:
    """Return where the rows, or the blocks, of the strands of so many segments are."""
    blocks = np.flatnonzero(layout.segments == segments)
    return slice(layout.first[blocks[0]], layout.first[blocks[-1] + 1]) if of_rows else slice(blocks[0], blocks[-1] + 1)
