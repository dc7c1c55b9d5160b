"""Level sets and densities of hair as grids of an OpenVDB file.

Bricks of a level set are leaves of a grid. Values are written bit for bit.
"""

import numpy as np

from hairpipe.data import Density, LevelSet
from hairpipe.io.vdb.vdb_write import BRANCHES, Grid, Tree
from hairpipe.levelset.grid_layout import BRICK

_VECTORS = {"class": "unknown", "vector_type": "contravariant relative"}


def surface_grids(surface: LevelSet) -> list[Grid]:
    """Return `surface`, a level set, and `vel`, vectors in the band."""
    band = {"half_width": surface.half_width}
    return [
        Grid("surface", surface_tree(surface), {"class": "level set", **band}),
        Grid("vel", velocity_tree(surface), {**_VECTORS, **band}),
    ]


def density_grids(density: Density) -> list[Grid]:
    """Return `density`, a fog of the length of hair per volume [m/m^3], and `hair_vel`, vectors where there is hair."""
    empty = np.empty((0, 3), int)
    first = density.low // BRICK
    before = density.low - BRICK * first
    after = -(before + density.length.shape) % BRICK
    wide = [(int(a), int(b)) for a, b in zip(before, after, strict=True)]
    blocks = [_blocks(np.pad(density.length, wide)), _blocks(np.pad(density.velocity, [*wide, (0, 0)]))]
    places = np.argwhere((blocks[0] > 0.0).any(axis=(3, 4, 5)))
    places = places[order_in_tree(first + places)]
    length, velocity = (values[tuple(places.T)] for values in blocks)
    leaves = first + places
    active = length > 0.0
    return [
        Grid("density", Tree(leaves, length, active, None, empty, 0.0, density.cell), {"class": "fog volume"}),
        Grid("hair_vel", Tree(leaves, velocity, active, None, empty, 0.0, density.cell), _VECTORS),
    ]


def _blocks(values: np.ndarray) -> np.ndarray:
    """Return values of whole blocks block by block, (na, nb, nc, 8, 8, 8, ...)."""
    a, b, c = (n // BRICK for n in values.shape[:3])
    parted = values.reshape(a, BRICK, b, BRICK, c, BRICK, *values.shape[3:])
    return np.moveaxis(parted, (2, 4), (1, 2))


def surface_tree(surface: LevelSet) -> Tree:
    """Return the distance, active in the band; beyond it is the width of the band with the distance's sign."""
    background = np.float32(surface.voxel * surface.half_width)
    leaves, bricks = leaves_of(surface)
    distance = surface.distance[bricks, :BRICK, :BRICK, :BRICK]
    inside = first_leaf(surface) + np.argwhere(surface.bricks == LevelSet.FAR_INSIDE)
    return Tree(leaves, distance, np.abs(distance) < background, distance > 0, inside, float(background), surface.voxel)


def velocity_tree(surface: LevelSet) -> Tree:
    """Return the velocity in the band; 0 beyond it."""
    leaves, bricks = leaves_of(surface)
    distance, velocity = (values[bricks, :BRICK, :BRICK, :BRICK] for values in (surface.distance, surface.velocity))
    active = (np.abs(distance) < np.float32(surface.voxel * surface.half_width)) & velocity.any(axis=-1)
    kept = active.any(axis=(1, 2, 3))
    return Tree(leaves[kept], velocity[kept], active[kept], None, np.empty((0, 3), int), 0.0, surface.voxel)


def leaves_of(surface: LevelSet) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the bricks' leaves, (B, 3) int, and of the bricks, (B,) int, in the order of a tree."""
    places = np.argwhere(surface.bricks >= 0)
    leaves = first_leaf(surface) + places
    order = order_in_tree(leaves)
    return leaves[order], surface.bricks[tuple(places[order].T)]


def first_leaf(surface: LevelSet) -> np.ndarray:
    """Return the index of the leaf of the first block of the bricks' lattice, (3,) int."""
    return np.rint(surface.origin / (BRICK * surface.voxel)).astype(int)


def order_in_tree(leaves: np.ndarray) -> np.ndarray:
    """Return the order of leaves, (N, 3) int, in a tree: by their nodes, from the root down."""
    units = [leaves >> sum(BRANCHES[level:]) for level in (0, 1, 2)]
    return np.lexsort(np.concatenate(units, axis=1).T[::-1])
