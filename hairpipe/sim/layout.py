"""Which strand sits in which lane: strands of equal segment count fill blocks of eight."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hairpipe.sim.lanes import WIDTH
from hairpipe.sim.lattice import AXIS, particle_count


@dataclass(frozen=True, eq=False)
class Layout:
    """Blocks of eight strands with the same number of segments; the last block of a class repeats its last strand.

    offsets   of the groom's points, (strands+1,) int32
    strands   strand in every lane, (blocks, WIDTH) int64
    idle      lanes that only repeat a strand, (blocks, WIDTH) bool
    segments  of the strands of a block, (blocks,) int64
    first     rows (particles) of block b are first[b]:first[b+1], (blocks+1,) int64
    """

    offsets: np.ndarray
    strands: np.ndarray
    idle: np.ndarray
    segments: np.ndarray
    first: np.ndarray

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.segments)

    def classes(self, points: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Blocks of each segment count, and the points of their strands lane by lane, (lanes, segments+1, 3)."""
        for segments in np.unique(self.segments):
            blocks = np.flatnonzero(self.segments == segments)
            starts = self.offsets[self.strands[blocks].reshape(-1)]
            yield blocks, points[starts[:, None] + np.arange(segments + 1)]

    def axis(self, values: np.ndarray) -> np.ndarray:
        """Collect the axis particles (m_0 ... m_n) of every strand in the order of the groom.

        values   (rows, 3, WIDTH)
        returns  (points, 3)
        """
        collected = np.empty((self.offsets[-1], 3))
        for segments in np.unique(self.segments):
            blocks = np.flatnonzero(self.segments == segments)
            rows = values[self.first[blocks[0]] : self.first[blocks[-1] + 1]]
            axis = rows.reshape(len(blocks), -1, 3, WIDTH)[:, AXIS].transpose(0, 3, 1, 2)
            starts = self.offsets[self.strands[blocks]]
            collected[starts[:, :, None] + np.arange(segments + 1)] = axis
        return collected


def lay_out(offsets: np.ndarray) -> Layout:
    """Sort strands into blocks, keeping their order within a segment count."""
    counts = np.diff(offsets).astype(np.int64) - 1
    strands, idle, segments = [], [], []
    for count in np.unique(counts):
        members = np.flatnonzero(counts == count)
        missing = -len(members) % WIDTH
        strands.append(np.pad(members, (0, missing), mode="edge").reshape(-1, WIDTH))
        idle.append((np.arange(len(members) + missing) >= len(members)).reshape(-1, WIDTH))
        segments.append(np.full(len(strands[-1]), count))
    sizes = particle_count(np.concatenate(segments))
    first = np.concatenate([[0], np.cumsum(sizes)])
    return Layout(offsets, np.concatenate(strands), np.concatenate(idle), np.concatenate(segments), first)
