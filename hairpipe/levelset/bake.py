"""Bake the signed distance and the velocity of a moving body: a narrow band, and coarsely what is inside it.

Blocks without bricks far inside a body have distance and velocity at their corners. Open surfaces, such as garments,
are sheets of a thickness, alone or over a solid body.

The bricks of a narrow band: which there are, and what their samples hold.

Velocities are those of the corners of the surface's triangles [m/s], (m, 3, 3) float64. Marks are those of the samples
of a lattice, from `marked_samples`, (x, y, z) uint8.
"""

from dataclasses import replace
from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import WIDTH, load, store
from hairpipe.geometry.triangle_tree import Tree, closest, closest_on_triangle, find_closest, tree_over
from hairpipe.geometry.vec3 import Vector
from hairpipe.levelset.closed_surface import Surface, checked, closed_surface
from hairpipe.levelset.grid_layout import Lattice, lattice_around, refuse_if_huge
from hairpipe.levelset.outer_shell import OUTSIDE, marked_samples, outer_surface
from hairpipe.levelset.sample import Field, field_of
from hairpipe.levelset.sample import distance as distance_to
from hairpipe.openvdb_library import ask
from hairpipe.values import LevelSet, Mesh
from hairpipe.values.body import BRICK

SIDE = BRICK + 1
# A stored sample takes 16 bytes: 1.6 GB.
MOST_STORED = 100_000_000


class Bricks(NamedTuple):
    """The bricks of a band, as in LevelSet."""

    places: np.ndarray  # index of the brick of every block, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32
    distance: np.ndarray  # [m], (B, 9, 9, 9) float32
    velocity: np.ndarray  # [m/s], (B, 9, 9, 9, 3) float32


class Band(NamedTuple):
    """Lattice of the samples, and width of the band."""

    first: np.ndarray  # index of the lattice's first sample, (3,) int64
    voxel: float  # spacing of the samples [m]
    width: float  # of the band [m]


def filled_bricks(tree: Tree, velocities: np.ndarray, lattice: Lattice, marks: np.ndarray, width: float) -> Bricks:
    """Return the bricks that a band of a width [m] around the surface touches; BadInput if they exceed the memory."""
    places = near_bricks(tree, lattice, width)
    refuse_if_huge(len(places) * SIDE**3, lattice.size, lattice.voxel, MOST_STORED)
    distance = np.empty((len(places), SIDE, SIDE, SIDE), np.float32)
    velocity = np.empty((*distance.shape, 3), np.float32)
    fill_bricks(tree, velocities, places, Band(lattice.first, lattice.voxel, width), marks, distance, velocity)
    index = np.pad(brick_index(places, marks), (0, 1), constant_values=LevelSet.FAR_OUTSIDE)
    share_samples(index, places, width, distance, velocity)
    kept = (np.abs(distance) < np.float32(width)).any(axis=(1, 2, 3))
    return Bricks(brick_index(places[kept], marks), distance[kept], velocity[kept])


def brick_index(places: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """Return the index of the brick of every block, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32."""
    corner = marks[:-1:BRICK, :-1:BRICK, :-1:BRICK] & OUTSIDE
    index = np.where(corner, LevelSet.FAR_OUTSIDE, LevelSet.FAR_INSIDE).astype(np.int32)
    index[tuple(places.T)] = np.arange(len(places), dtype=np.int32)
    return index


def near_bricks(tree: Tree, lattice: Lattice, width: float) -> np.ndarray:
    """Return the bricks that the band of a width [m] may touch, (n, 3) int64, in memory order; pure."""
    distances = np.empty(lattice.bricks)
    reach = width + np.sqrt(3) * BRICK / 2 * lattice.voxel  # No sample is farther from the middle of its brick.
    measure_middles(tree, lattice.first, lattice.voxel, reach, distances)
    return np.argwhere(distances < reach)


@njit(cache=True)
def measure_middles(tree: Tree, first: np.ndarray, voxel: float, reach: float, distances: np.ndarray) -> None:
    """Write the distance from the middle of every brick to the surface [m], exact within reach [m]."""
    near = 0
    for a, b, c in np.ndindex(distances.shape):
        x = (first[0] + BRICK * a + BRICK / 2) * voxel
        y = (first[1] + BRICK * b + BRICK / 2) * voxel
        z = (first[2] + BRICK * c + BRICK / 2) * voxel
        squared, near, _ = closest(tree, (x, y, z), reach * reach, near)  # The nearest so far is a good guess.
        distances[a, b, c] = np.sqrt(squared)


@njit(cache=True, parallel=True)
def fill_bricks(
    tree: Tree,
    velocities: np.ndarray,
    places: np.ndarray,
    band: Band,
    marks: np.ndarray,
    distance: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Fill, in place, the first 8 x 8 x 8 samples of bricks: clamped distance, and velocity of the closest point."""
    first, voxel, width = band.first, band.voxel, band.width
    for n in prange(len(places)):
        a, b, c = BRICK * places[n, 0], BRICK * places[n, 1], BRICK * places[n, 2]
        at = np.empty((3, WIDTH))
        found = np.zeros((1, WIDTH))
        for i, j, k in np.ndindex(BRICK // 2, BRICK // 2, BRICK // 2):  # cubes of samples
            for lane in range(WIDTH):
                at[0, lane] = (first[0] + a + 2 * i + (lane >> 2 & 1)) * voxel
                at[1, lane] = (first[1] + b + 2 * j + (lane >> 1 & 1)) * voxel
                at[2, lane] = (first[2] + c + 2 * k + (lane >> 0 & 1)) * voxel
            # Of equally near triangles the guess may decide: it must not depend on what a thread did before.
            p = load(at, (0,)), load(at, (1,)), load(at, (2,))
            store(found, (0,), find_closest(tree, p, np.inf, int(found[0, 0])))
            for lane in range(WIDTH):
                u, v, w = 2 * i + (lane >> 2 & 1), 2 * j + (lane >> 1 & 1), 2 * k + (lane >> 0 & 1)
                near = int(found[0, lane])
                squared, weights = closest_on_triangle(tree.corners, near, (at[0, lane], at[1, lane], at[2, lane]))
                far = np.sqrt(squared)
                # Outside the band's border is the largest distance; inside it goes on, as hair may be deep.
                distance[n, u, v, w] = min(far, width) if marks[a + u, b + v, c + w] & OUTSIDE else -far
                write_velocity(velocities[tree.triangles[near]], weights, velocity[n, u, v, w])


@inlined
def write_velocity(corners: np.ndarray, weights: Vector, out: np.ndarray) -> None:
    """Write the velocity at a point of a triangle, from those of its corners, to out, (3,)."""
    for axis in range(3):
        out[axis] = weights[0] * corners[0, axis] + weights[1] * corners[1, axis] + weights[2] * corners[2, axis]


@njit(cache=True)
def share_samples(
    index: np.ndarray, places: np.ndarray, width: float, distance: np.ndarray, velocity: np.ndarray
) -> None:
    """Fill, in place, the last samples of every brick along each axis: they are the first of the brick beyond.

    If that brick is missing, the sample is beyond the band: it takes sign and velocity of the previous sample, in a
    brick that is the same for all bricks with this sample. Inside, the distance is extrapolated.
    """
    last = BRICK - 1
    for n in range(len(places)):
        a, b, c = places[n]
        for i, j, k in np.ndindex(SIDE, SIDE, SIDE):
            if max(i, j, k) == BRICK:  # Copied, so that two bricks agree to the bit on their common face.
                m, u, v, w = holder(index, BRICK * a + i, BRICK * b + j, BRICK * c + k)
                near = distance[m, min(u, last), min(v, last), min(w, last)]
                if max(u, v, w) < BRICK:
                    distance[n, i, j, k] = near
                elif near > 0.0:
                    distance[n, i, j, k] = width
                else:
                    nearer = distance[m, min(u, 2 * last - u), min(v, 2 * last - v), min(w, 2 * last - w)]
                    distance[n, i, j, k] = 2.0 * near - nearer
                for axis in range(3):
                    velocity[n, i, j, k, axis] = velocity[m, min(u, last), min(v, last), min(w, last), axis]


@njit(cache=True)
def holder(index: np.ndarray, i: int, j: int, k: int) -> tuple[int, int, int, int]:
    """Return the first brick that contains a sample, preferably as its first sample, and the index in it."""
    for a in (i // BRICK, (i - 1) // BRICK):  # In a fixed order: all bricks that share a sample find the same holder.
        for b in (j // BRICK, (j - 1) // BRICK):
            for c in (k // BRICK, (k - 1) // BRICK):
                if index[a, b, c] >= 0:
                    return index[a, b, c], i - BRICK * a, j - BRICK * b, k - BRICK * c
    return -1, 0, 0, 0


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

    Where a sheet lies so near to the solid that nothing fits between them, the way out of both is across the sheet. The
    surface of both together is also given.
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
        for i, j, k in np.ndindex(SIDE, SIDE, SIDE):
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
                write_velocity(velocities[tree.triangles[near]], w, velocity[n, i, j, k])


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
                write_velocity(velocities[tree.triangles[near]], w, velocity[n, i, j, k])


def inner_corners(tree: Tree, velocities: np.ndarray, lattice: Lattice, places: np.ndarray) -> np.ndarray:
    """Return signed distance [m] and velocity [m/s] at the corners of blocks far inside, 0 at others, (..., 4) float32.

    Between them, a distance with a radius of curvature R has an error of up to (8 voxel)^2 / 4 R.
    """
    corners = np.zeros((*np.add(places.shape, 1), 4), np.float32)
    far = np.pad(places == LevelSet.FAR_INSIDE, 1)
    touched = np.zeros(corners.shape[:3], bool)
    for a, b, c in np.ndindex(2, 2, 2):
        touched |= far[a : a + touched.shape[0], b : b + touched.shape[1], c : c + touched.shape[2]]
    _fill(tree, velocities, np.ascontiguousarray(np.argwhere(touched)), lattice.first, lattice.voxel, corners)
    return corners


@njit(cache=True, parallel=True)
def _fill(
    tree: Tree, velocities: np.ndarray, which: np.ndarray, first: np.ndarray, voxel: float, corners: np.ndarray
) -> None:
    for n in prange(len(which)):
        a, b, c = which[n]
        x, y, z = (first[0] + BRICK * a) * voxel, (first[1] + BRICK * b) * voxel, (first[2] + BRICK * c) * voxel
        squared, near, w = closest(tree, (x, y, z), np.inf, 0)
        corners[a, b, c, 0] = -np.sqrt(squared)  # Inside, so the sign is known without `marks`.
        write_velocity(velocities[tree.triangles[near]], w, corners[a, b, c, 1:])


# Of the area, without a word: the tips of ears and noses fall between samples at any spacing.
LOST = 0.01


def bake(mesh: Mesh, voxel: float, half_width: float, open_edges: str = "fill") -> LevelSet:
    """Return the signed distance and the velocity of a body in a band around its surface, and everywhere inside; pure.

    phi(x) = -+min |x - p| over the points p of the surface reached from outside, negative inside; v(x) = v(p)

    voxel       spacing of the samples [m]; they lie at integer multiples of it
    half_width  half width of the band, in voxels
    open_edges  "fill": holes are capped, with a warning; "refuse": they are an error

    The distance is that to the triangles themselves, in double precision. The sign is that of a flood from outside
    along the samples, which triangles block. OpenVDB's conversion of a mesh is less accurate in both: the bench
    `levelset` compares them with brute force (docs/results/experiments.md).

    Raises BadInput for a mesh that is broken, empty, encloses no sample, or is too large for its voxel.
    """
    surface = closed_surface(mesh, open_edges)
    return bake_solid(surface, lattice_around(surface.corners, voxel, half_width), half_width)


def bake_sheets(
    body: Mesh | None, sheets: Mesh, voxel: float, half_width: float, open_edges: str, thickness: float | None
) -> LevelSet:
    """Return the level set of a body, see `bake`, and of open surfaces with a thickness [m], or two voxels; pure.

    Closed pieces of the sheets are solid. The middle of a sheet, half a thickness from its surface, is inside by any
    sample around it. Raises BadInput as `bake` does, and for a thickness below two voxels or above that of the band.
    """
    thick = 2.0 * voxel if thickness is None else thickness
    if not 2.0 * voxel <= thick <= 2.0 * half_width * voxel:
        right = f"{2.0 * voxel:g} to {2.0 * half_width * voxel:g}: two voxels to twice the half width"
        raise BadInput(f"sheets are {thick:g} m thick", where="thickness", right=right)
    closed, thin = split_pieces(checked(sheets))
    solids = [closed_surface(mesh, open_edges) for mesh in (body, closed) if mesh is not None and len(mesh.triangles)]
    layers = Surface(thin.points[thin.triangles], thin.rates[thin.triangles])
    corners = np.concatenate([*(solid.corners for solid in solids), layers.corners])
    lattice = lattice_around(corners, voxel, half_width + 0.5 * thick / voxel)
    both = Surface(corners, np.concatenate([*(solid.velocities for solid in solids), layers.velocities]))
    if solids:
        closed_ones = Surface(*(values[: len(corners) - len(layers.corners)] for values in both))
        solid = bake_solid(closed_ones, lattice, half_width)
    else:
        nothing = np.zeros((0, SIDE, SIDE, SIDE, 3), np.float32)
        inner = np.zeros((*np.add(lattice.bricks, 1), 4), np.float32)
        bricks = np.full(lattice.bricks, LevelSet.FAR_OUTSIDE, np.int32)
        solid = LevelSet(bricks, nothing[..., 0], nothing, inner, lattice.first * voxel, voxel, half_width)
    return with_sheets(solid, layers, both, lattice, thick) if len(thin.triangles) else solid


def bake_solid(surface: Surface, lattice: Lattice, half_width: float) -> LevelSet:
    """Return the level set of a closed surface, with a warning of parts that are too thin; pure."""
    found, lost = bake_surface(surface, lattice, half_width)
    if lost > LOST:
        share = f"{lost:.0%} of the surface"
        warn(f"body: {share} is too thin for voxel = {lattice.voxel:g} m, and does not stop hair", stacklevel=3)
    return found


def bake_surface(surface: Surface, lattice: Lattice, half_width: float) -> tuple[LevelSet, float]:
    """Return the level set of a closed surface, see `bake`, and the share of its area that is too thin for it; pure."""
    voxel = lattice.voxel
    marks = marked_samples(surface.corners, lattice)
    if (marks & OUTSIDE).all():
        raise BadInput(f"the body encloses no sample at voxel = {voxel:g} m", where="body", right="a smaller voxel")
    outer = outer_surface(surface, marks, lattice)
    tree = tree_over(outer.surface.corners)
    bricks = filled_bricks(tree, outer.surface.velocities, lattice, marks, half_width * voxel)
    inner = inner_corners(tree, outer.surface.velocities, lattice, bricks.places)
    found = LevelSet(bricks.places, bricks.distance, bricks.velocity, inner, lattice.first * voxel, voxel, half_width)
    return found, outer.lost


def bake_by_openvdb(mesh: Mesh, voxel: float, half_width: float, open_edges: str) -> LevelSet:
    """Return the level set of `bake`, with distances and signs by OpenVDB's createLevelSetFromPolygons in the band.

    Velocities, bricks and distances beyond the band inside are those of `bake`, see there for arguments and errors.
    BadInput also where OpenVDB's module is missing or fails.
    """
    surface = closed_surface(mesh, open_edges)
    lattice = lattice_around(surface.corners, voxel, half_width)
    ours = bake_solid(surface, lattice, half_width)
    where = {"first": lattice.first, "samples": np.array(lattice.samples)}
    given = {"corners": surface.corners, "voxel": voxel, "half_width": half_width}
    theirs = ask("levelset", "bake_levelset", **given, **where)["distance"]
    places = np.argwhere(ours.bricks >= 0)
    distance = np.empty_like(ours.distance)
    for a, b, c in places.tolist():
        first, other, last = (slice(BRICK * i, BRICK * i + SIDE) for i in (a, b, c))
        distance[ours.bricks[a, b, c]] = theirs[first, other, last]
    width = np.float32(voxel * half_width)
    inside = np.where(distance <= -width, np.minimum(ours.distance, -width), distance)
    found = np.where(distance >= width, width, inside)
    return LevelSet(ours.bricks, found, ours.velocity, ours.inner, ours.origin, voxel, half_width)
