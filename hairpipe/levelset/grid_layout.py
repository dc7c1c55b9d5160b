"""The samples a level set is baked on: a lattice fixed in the world, cut into bricks of 8 voxels a side."""

from dataclasses import dataclass

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values.body import BRICK

# While a body is baked, each takes a byte: 1 GB.
MOST_SAMPLES = 1_000_000_000


@dataclass(frozen=True)
class Lattice:
    """Sample (i, j, k) lies at voxel * (first + (i, j, k)); brick (a, b, c) begins at sample 8 (a, b, c).

    `first` is a multiple of 8, so that bricks of two frames coincide, and coincide with the leaves of an OpenVDB tree.
    """

    first: np.ndarray  # index of the first sample, (3,) int64
    bricks: tuple[int, int, int]  # along each axis
    voxel: float  # spacing of the samples [m]

    @property
    def samples(self) -> tuple[int, int, int]:
        """Number of samples along each axis; the last ones are the far corners of the last bricks."""
        a, b, c = self.bricks
        return BRICK * a + 1, BRICK * b + 1, BRICK * c + 1

    @property
    def size(self) -> np.ndarray:
        """Extent along each axis [m], (3,) float64."""
        return np.array(self.bricks) * BRICK * self.voxel


def lattice_around(corners: np.ndarray, voxel: float, half_width: float) -> Lattice:
    """Return the lattice that contains a surface and its band, with at least one more sample on all sides; pure.

    Raises BadInput, naming a valid voxel size, if the lattice would be too large.
    """
    block = BRICK * voxel
    margin = (half_width + 1) * voxel
    low = np.floor((corners.min(axis=(0, 1)) - margin) / block)
    high = np.ceil((corners.max(axis=(0, 1)) + margin) / block)
    bricks = high - low
    refuse_if_huge(BRICK**3 * float(np.prod(bricks)), bricks * block, voxel, MOST_SAMPLES)
    return Lattice((BRICK * low).astype(np.int64), tuple(bricks.astype(int).tolist()), voxel)


def refuse_if_huge(count: float, size: np.ndarray, voxel: float, most: int) -> None:
    """Raise BadInput if there would be more samples than `most`, naming a valid voxel size.

    size  size of the lattice [m], (3,)
    """
    if count > most:
        box = " x ".join(f"{side:.3g}" for side in size)
        fits = voxel * (count / most) ** (1 / 3) * 1.1
        raise BadInput(
            f"a body with its band {box} m large would have {count:.2g} samples at voxel = {voxel:g} m",
            where="body",
            right=f"at most {most:.0e}: voxel = {fits:.2g} or more, or a smaller body",
        )
