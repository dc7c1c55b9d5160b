"""Open surfaces, such as garments, as sheets of a thickness, alone or over a solid body."""

from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.geometry.triangle_tree import Tree, closest, tree_over
from hairpipe.levelset.bricks import MOST_STORED, SIDE, Band, near_bricks
from hairpipe.levelset.closed_surface import Surface
from hairpipe.levelset.grid_layout import BRICK, Lattice, refuse_if_huge
from hairpipe.levelset.sample import Field, field_of
from hairpipe.levelset.sample import distance as distance_to
from hairpipe.values import LevelSet, Mesh


def split_pieces(mesh: Mesh) -> tuple[Mesh, Mesh]:
    """Return the closed pieces of a mesh, and those with an edge of one triangle alone; pure.

    Coincident points are one. Where more than two triangles share an edge, pieces are separate.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    _, places = np.unique(mesh.points, axis=0, return_inverse=True)
    ends = np.sort(places.reshape(-1)[mesh.triangles][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, edges, uses = np.unique(ends @ [places.max() + 1, 1], return_inverse=True, return_counts=True)
    order = np.argsort(edges, kind="stable")
    pairs = (order[np.flatnonzero(uses[edges[order]] == 2)] // 3).reshape(-1, 2).T
    count = len(mesh.triangles)
    _, pieces = connected_components(coo_array((np.ones(pairs.shape[1]), pairs), shape=(count, count)), directed=False)
    is_open = np.isin(pieces, pieces[np.flatnonzero(uses[edges] == 1) // 3])
    closed, sheets = (Mesh(mesh.points, mesh.triangles[kept], mesh.velocities) for kept in (~is_open, is_open))
    return closed, sheets


def with_sheets(solid: LevelSet, sheets: Surface, both: Surface, lattice: Lattice, thickness: float) -> LevelSet:
    """Return the level set of the union of a solid and all points within half a thickness [m] of sheets; pure.

    solid  on the lattice, whose band encloses the sheets
    both   surface of the solid, and the sheets

    Where a sheet lies so near to the solid that nothing fits between them, the way out of both is across the sheet.
    """
    tree = tree_over(sheets.corners)
    width = solid.half_width * solid.voxel
    half = 0.5 * thickness
    near = np.zeros(lattice.bricks, bool)
    near[tuple(near_bricks(tree, lattice, width + half).T)] = True
    places = np.argwhere((solid.bricks >= 0) | (near & (solid.bricks == LevelSet.FAR_OUTSIDE)))
    refuse_if_huge(len(places) * SIDE**3, lattice.size, lattice.voxel, MOST_STORED)
    own = solid.bricks[tuple(places.T)]
    distance = np.full((len(places), SIDE, SIDE, SIDE), width, np.float32)
    velocity = np.zeros((*distance.shape, 3), np.float32)
    distance[own >= 0], velocity[own >= 0] = solid.distance[own[own >= 0]], solid.velocity[own[own >= 0]]
    lay(tree, sheets.velocities, places, lattice.first, half, field_of(solid), distance, velocity)
    band = Band(lattice.first, lattice.voxel, float(np.float32(width)))
    move_outside(tree_over(both.corners), both.velocities, places, band, distance, velocity)
    kept = (own >= 0) | (distance < np.float32(width)).any(axis=(1, 2, 3))
    bricks = solid.bricks.copy()
    bricks[tuple(places[kept].T)] = np.arange(kept.sum())
    return replace(solid, bricks=bricks, distance=distance[kept], velocity=velocity[kept])


@njit(cache=True, parallel=True)
def lay(
    tree: Tree,
    velocities: np.ndarray,
    places: np.ndarray,
    first: np.ndarray,
    half: float,
    solid: Field,
    distance: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Lower distances [m] to those of sheets, of half a thickness [m], where they are nearer, with their velocities."""
    voxel = 1.0 / solid.per_metre
    for n in prange(len(places)):
        near = 0
        for i in range(SIDE):
            for j in range(SIDE):
                for k in range(SIDE):
                    x = (first[0] + BRICK * places[n, 0] + i) * voxel
                    y = (first[1] + BRICK * places[n, 1] + j) * voxel
                    z = (first[2] + BRICK * places[n, 2] + k) * voxel
                    before = distance[n, i, j, k]
                    squared, near, w = closest(tree, (x, y, z), (half + solid.background) ** 2, near)
                    far = np.sqrt(squared)
                    found = far - half
                    c = tree.corners[near]
                    foot = w[0] * c[0] + w[1] * c[1] + w[2] * c[2]
                    # Between the solid and a sheet whose near side is in the solid: out is across the sheet.
                    if before + far < half and before < distance_to(solid, foot[0], foot[1], foot[2]):
                        found = -far - half
                    if found < before:
                        distance[n, i, j, k] = found
                        t = tree.triangles[near]
                        for axis in range(3):
                            v0, v1, v2 = velocities[t, 0, axis], velocities[t, 1, axis], velocities[t, 2, axis]
                            velocity[n, i, j, k, axis] = w[0] * v0 + w[1] * v1 + w[2] * v2


@njit(cache=True, parallel=True)
def move_outside(
    tree: Tree, velocities: np.ndarray, places: np.ndarray, band: Band, distance: np.ndarray, velocity: np.ndarray
) -> None:
    """Write velocities of the closest points beyond the band: by them a part is found between frames.

    Arguments are those of `fill_bricks`, whose clamped distance does not decide between sheet and solid there.
    """
    first, voxel, width = band.first, band.voxel, band.width
    for n in prange(len(places)):
        near = 0
        for i, j, k in np.ndindex(SIDE, SIDE, SIDE):
            if distance[n, i, j, k] >= width:
                a, b, c = BRICK * places[n, 0] + i, BRICK * places[n, 1] + j, BRICK * places[n, 2] + k
                x, y, z = (first[0] + a) * voxel, (first[1] + b) * voxel, (first[2] + c) * voxel
                _, near, w = closest(tree, (x, y, z), np.inf, near)
                v = velocities[tree.triangles[near]]
                for axis in range(3):
                    velocity[n, i, j, k, axis] = w[0] * v[0, axis] + w[1] * v[1, axis] + w[2] * v[2, axis]
