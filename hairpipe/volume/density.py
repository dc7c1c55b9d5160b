"""Hair per volume, as it is put on a grid, and sections through that."""

import numpy as np

from hairpipe.data import Density, Strands
from hairpipe.volume.strand_samples import reach_of, sample_strands
from hairpipe.volume.transfer import deposit, mean_velocities


def density_of(hair: Strands, cell: float) -> Density:
    """Return the density of hair on nodes at a distance [m]; strands that are not finite are left out; pure.

    Raises BadInput where the grid would be too large, see `sample_strands`.
    """
    points, offsets = hair.points.astype(float), hair.offsets
    samples = sample_strands(points, offsets, reach_of(points, offsets), cell)
    if samples is None:
        return Density(np.zeros(3, np.int32), cell, np.zeros((0, 0, 0), np.float32), np.zeros((0, 0, 0, 3), np.float32))
    grid = deposit(samples, lengths_at_points(points, offsets), hair.velocities.astype(float))
    velocities = np.empty((*samples.counts, 3))
    mean_velocities(grid, velocities)
    length = (grid[..., 0] / cell**3).astype(np.float32)
    return Density(samples.low.astype(np.int32), cell, length, velocities.astype(np.float32))


def lengths_at_points(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return half of the segments beside each point [m], (P,); 0 for strands that are not finite."""
    lengths = np.append(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.0)
    lengths[offsets[1:] - 1] = 0.0
    shares = 0.5 * (lengths + np.roll(lengths, 1))
    return np.where(np.isfinite(shares), shares, 0.0)


def section_of(density: Density, axis: int, place: float) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """Cut a density across an axis at a place [m], linear between nodes.

    Returns the length of hair per volume [m/m^3], (n, m), the first of the other axes to the right (z of y is), the
    second upwards, and left, right, bottom and top [m] of the nodes.
    """
    across, up = {0: (2, 1), 1: (0, 2), 2: (0, 1)}[axis]
    u = place / density.cell - density.low[axis]
    planes = np.moveaxis(density.length, (axis, up, across), (0, 1, 2)).astype(float)
    i, share = int(np.floor(u)), u - np.floor(u)
    found = np.zeros(planes.shape[1:])
    for plane, weight in ((i, 1.0 - share), (i + 1, share)):
        if 0 <= plane < len(planes):
            found += weight * planes[plane]
    low, cell = density.low, density.cell
    ends = [cell * end for a in (across, up) for end in (low[a], low[a] + density.length.shape[a] - 1)]
    return found, (ends[0], ends[1], ends[2], ends[3])
