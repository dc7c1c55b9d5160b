"""Density of hair on a grid, and the hair shell: its isosurface at a share of the median density.

The shell is that of Petrovic, Henne, Anderson 2005, Sec. 4.1. They solve |grad S| = 1 from the density; we extract a
mesh and bake it as a body, so that the shell can be drawn, exported and used as a collider.
"""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from hairpipe.errors import BadInput
from hairpipe.geometry.isosurface import extract_surface
from hairpipe.values import Density, Mesh, Strands
from hairpipe.values.groom import lengths_at_points, reach_of
from hairpipe.volume.transfer import MOST_NODES, deposit, mean_velocities, sample_strands

_ON_LATTICE = 1e-4  # of a cell: files keep positions in single precision


def density_of(hair: Strands, cell: float) -> Density:
    """Return the density of hair on nodes at a distance [m]; strands that are not finite are left out; pure.

    Raises BadInput where the grid would be too large, see `sample_strands`.
    """
    points = hair.points.astype(float)
    offsets = hair.offsets
    samples = sample_strands(points, offsets, reach_of(points, offsets), cell)
    if samples is None:
        return Density(np.zeros(3, np.int32), cell, np.zeros((0, 0, 0), np.float32), np.zeros((0, 0, 0, 3), np.float32))
    grid = deposit(samples, lengths_at_points(points, offsets), hair.velocities.astype(float))
    velocities = np.empty((*samples.counts, 3))
    mean_velocities(grid, velocities)
    length = (grid[..., 0] / cell**3).astype(np.float32)
    return Density(samples.low.astype(np.int32), cell, length, velocities.astype(np.float32))


def density_of_voxels(indices: np.ndarray, values: np.ndarray, cell: float, first: np.ndarray) -> Density:
    """Return a density on the lattice of the world, from voxels of one that may be shifted against it; pure.

    indices  of the voxels, (n, 3); values  what is there, (n,), negative ones count as 0
    cell     of both [m]
    first    where the voxel of index 0 lies [m], (3,)

    Raise BadInput where a value is not finite, or voxels are too far apart.
    """
    if not np.isfinite(values).all():
        raise BadInput(f"{np.count_nonzero(~np.isfinite(values))} voxels are not finite", right="a density")
    there = values > 0.0
    if not there.any():
        return Density(np.zeros(3, np.int32), cell, np.zeros((0, 0, 0), np.float32), np.zeros((0, 0, 0, 3), np.float32))
    at = indices[there] + first / cell
    at = np.where(np.abs(at - np.rint(at)) < _ON_LATTICE, np.rint(at), at)
    low = np.floor(at.min(axis=0))
    counts = np.ceil(at.max(axis=0)) - low + 1.0
    if np.prod(counts) > MOST_NODES:
        raise BadInput(f"a box around the density has {np.prod(counts):.2g} nodes", right=f"at most {MOST_NODES:,}")
    shape = counts.astype(int)
    node = np.floor(at)
    flat = np.zeros(int(np.prod(shape)))
    share = at - node
    for corner in np.ndindex(2, 2, 2):
        weights = np.prod(np.where(corner, share, 1.0 - share), axis=1)
        own = weights > 0.0
        index = np.ravel_multi_index(tuple((node[own] - low).astype(int).T + np.array(corner)[:, None]), tuple(shape))
        flat += np.bincount(index, weights[own] * values[there][own], minlength=len(flat))
    length = flat.reshape(shape).astype(np.float32)
    return Density(low.astype(np.int32), cell, length, np.zeros((*shape, 3), np.float32))


REACH = 4
"""Radius of the blur, in standard deviations."""


def shell_of(density: Density, blur: float, level: float) -> Mesh:
    """Return the closed surface of hair, outward, with the mean velocity of the hair there; pure.

    blur   standard deviation of a Gaussian by which the density is blurred before, in cells
    level  density of the surface, over the median of the blurred density, weighted by hair

    Petrovic, Henne, Anderson 2005, Sec. 4.1. Raises BadInput where there is no hair, or no place of that density.
    """
    if not density.length.any():
        raise BadInput("there is no hair", where="density")
    margin = int(np.ceil(REACH * blur)) + 1
    hair = np.pad(density.length.astype(float), margin)
    blurred = _blurred(hair, blur)
    order = np.argsort(blurred, axis=None, kind="stable")
    heaped = np.cumsum(hair.ravel()[order])
    surface = level * float(blurred.ravel()[order[np.searchsorted(heaped, 0.5 * heaped[-1])]])
    axes = tuple(density.cell * (low - margin + np.arange(n)) for low, n in zip(density.low, hair.shape, strict=True))
    points, triangles = extract_surface(surface - blurred, axes)
    if not len(triangles):
        raise BadInput(f"no density reaches {level:g} of the median", where="level", right="less")
    places = (points / density.cell - density.low + margin).T
    mass = map_coordinates(blurred, places, order=1)
    momenta = hair[..., None] * np.pad(density.velocity, [*[(margin, margin)] * 3, (0, 0)])
    flow = np.stack([map_coordinates(_blurred(momenta[..., c], blur), places, order=1) for c in range(3)], axis=1)
    return Mesh(points, triangles, flow / mass[:, None])


def _blurred(field: np.ndarray, blur: float) -> np.ndarray:
    return gaussian_filter(field, blur, mode="constant", truncate=REACH)
