"""The part of a closed surface that the outside touches, without the sheets that lie inside other parts.

Outside are the samples that are connected to the border of their lattice without crossing the surface. They also
determine which triangles face inward, whatever their winding was.
"""

import warnings
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hairpipe.levelset.closed_surface import Surface, capped, edge_uses, holes
from hairpipe.levelset.grid_layout import Lattice, lattice_around
from hairpipe.values import Body, Mesh
from hairpipe.values.triangles import area_vectors, normalized

# Bits of a sample: the step to the next sample along x, y, z meets the surface; the sample is outside.
BLOCKED = (1, 2, 4)
OUTSIDE = 8
# A crossing this close to a sample [voxels] blocks the steps on both sides of it, so that rounding opens no leak.
TOUCH = 1e-9


def marked_samples(corners: np.ndarray, lattice: Lattice) -> np.ndarray:
    """Return the bits BLOCKED and OUTSIDE of every sample, (x, y, z) uint8, by the triangles of a closed surface; pure.

    A sample is outside if a path along the lattice joins it to the border and crosses no triangle. Orientation,
    overlapping parts, and closed parts within others have no effect: all unreached samples are inside.
    """
    marks = np.zeros(lattice.samples, np.uint8)
    places = corners / lattice.voxel - lattice.first
    for axis in range(3):
        block_steps(places, axis, marks)
    marks[0] |= OUTSIDE
    while flood_forward(marks) + flood_backward(marks):
        pass
    return marks


@njit(cache=True)
def side(pu: float, pv: float, qu: float, qv: float, u: float, v: float) -> float:
    """Return twice the signed area of p, q and (u, v); exactly opposite when p and q are exchanged.

    So two triangles agree on the side of their common edge on which a line passes, and no line passes between them.
    """
    if pu < qu or (pu == qu and pv < qv):
        return (qu - pu) * (v - pv) - (qv - pv) * (u - pu)
    return (qu - pu) * (v - qv) - (qv - pv) * (u - qu)


@njit(cache=True)
def block_steps(places: np.ndarray, axis: int, marks: np.ndarray) -> None:
    """Mark, in place, the steps along an axis that meet a triangle; places are in samples from the first, (m, 3, 3)."""
    second, third = (axis + 1) % 3, (axis + 2) % 3
    step = np.zeros(3, np.int64)
    for t in range(len(places)):
        p, q, r = places[t, 0], places[t, 1], places[t, 2]
        pu, pv, qu, qv, ru, rv = p[second], p[third], q[second], q[third], r[second], r[third]
        for u in range(int(np.ceil(min(pu, qu, ru))), int(np.floor(max(pu, qu, ru))) + 1):
            for v in range(int(np.ceil(min(pv, qv, rv))), int(np.floor(max(pv, qv, rv))) + 1):
                a = side(qu, qv, ru, rv, u, v)
                b = side(ru, rv, pu, pv, u, v)
                c = side(pu, pv, qu, qv, u, v)
                within = (a >= 0 and b >= 0 and c >= 0) or (a <= 0 and b <= 0 and c <= 0)
                if not within or a + b + c == 0.0:  # Edge-on along this axis: the triangle is met along another.
                    continue
                depth = (a * p[axis] + b * q[axis] + c * r[axis]) / (a + b + c)
                step[second], step[third] = u, v
                for near in (depth - TOUCH, depth + TOUCH):
                    step[axis] = int(np.floor(near))
                    marks[step[0], step[1], step[2]] |= BLOCKED[axis]


@njit(cache=True)
def flood_forward(marks: np.ndarray) -> int:
    """Mark, in place, the samples that a step towards +x, +y or +z joins to the outside; return how many."""
    nx, ny, nz = marks.shape
    found = 0
    for i in range(nx):  # In the order of memory, neighbours before: what is found is passed on in the same pass.
        for j in range(ny):
            for k in range(nz):
                if marks[i, j, k] & OUTSIDE:
                    continue
                x = i > 0 and marks[i - 1, j, k] & (OUTSIDE | 1) == OUTSIDE
                y = j > 0 and marks[i, j - 1, k] & (OUTSIDE | 2) == OUTSIDE
                z = k > 0 and marks[i, j, k - 1] & (OUTSIDE | 4) == OUTSIDE
                if x or y or z:
                    marks[i, j, k] |= OUTSIDE
                    found += 1
    return found


@njit(cache=True)
def flood_backward(marks: np.ndarray) -> int:
    """Mark, in place, the samples that a step towards -x, -y or -z joins to the outside; return how many."""
    nx, ny, nz = marks.shape
    found = 0
    for i in range(nx - 1, -1, -1):  # The other way round: passes both ways reach all, without a queue.
        for j in range(ny - 1, -1, -1):
            for k in range(nz - 1, -1, -1):
                here = marks[i, j, k]
                if here & OUTSIDE:
                    continue
                x = i < nx - 1 and not here & 1 and marks[i + 1, j, k] & OUTSIDE
                y = j < ny - 1 and not here & 2 and marks[i, j + 1, k] & OUTSIDE
                z = k < nz - 1 and not here & 4 and marks[i, j, k + 1] & OUTSIDE
                if x or y or z:
                    marks[i, j, k] |= OUTSIDE
                    found += 1
    return found


HIDDEN, BACKED, LOST = range(3)
# Halving the longest side goes this deep only for a triangle 2^60 voxels long.
DEEPEST = 128


class Outer(NamedTuple):
    """The part of a surface reached from outside."""

    surface: Surface  # its triangles; partly hidden ones are cut into pieces no larger than a voxel
    lost: float  # share of their area without inside samples behind it: parts too thin for the voxel


def outer_surface(surface: Surface, marks: np.ndarray, lattice: Lattice) -> Outer:
    """Return the part of a surface reached from outside, by the marks of samples; pure.

    The closest point of a point outside is always on this part. A point inside must not refer to a sheet hidden within
    the body: its distance and its velocity would be those of an unreachable surface. Where parts meet, sheets end
    within two voxels behind the crease.
    """
    triangles = np.concatenate([surface.corners / lattice.voxel - lattice.first, surface.velocities], axis=2)
    counts, areas = sort_pieces(triangles, marks, np.empty((0, 3, 6)))
    lost = areas[:, LOST].sum()
    touched = areas[:, BACKED:].sum()
    whole = areas[:, HIDDEN] == 0
    cut = ~whole & (counts > 0)
    pieces = np.empty((counts[cut].sum(), 3, 6))
    sort_pieces(triangles[cut], marks, pieces)
    corners = np.concatenate([surface.corners[whole], (pieces[:, :, :3] + lattice.first) * lattice.voxel])
    velocities = np.concatenate([surface.velocities[whole], pieces[:, :, 3:]])
    return Outer(Surface(corners, velocities), float(lost / touched))


@njit(cache=True)
def sort_pieces(triangles: np.ndarray, marks: np.ndarray, pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut triangles, (m, 3, 6), into pieces no larger than a voxel and write those reached from outside, (p, 3, 6).

    Returns the number of reached pieces of each triangle, (m,) int64, and the area of its pieces that are hidden,
    backed by an inside sample, and lost, (m, 3) float64 [voxel^2].
    """
    counts = np.zeros(len(triangles), np.int64)
    areas = np.zeros((len(triangles), 3))
    stack = np.empty((DEEPEST, 3, 6))  # Depth first: the stack is as high as the deepest cut, not as all pieces.
    at = 0
    for t in range(len(triangles)):
        copy(triangles[t], stack[0])
        top = 1
        while top > 0:
            piece = stack[top - 1]
            longest = longest_side(piece)
            if longest >= 0:
                halve(piece, longest, stack[top])
                top += 1
                continue
            top -= 1
            found_class = class_of(piece, marks)
            areas[t, found_class] += area(piece)
            if found_class != HIDDEN:
                counts[t] += 1
                if at < len(pieces):  # A first pass without room only counts.
                    copy(piece, pieces[at])
                    at += 1
    return counts, areas


@njit(cache=True)
def copy(piece: np.ndarray, other: np.ndarray) -> None:
    """Copy a piece into `other`: a loop compiles in a fraction of the time of an assignment to a slice."""
    for c in range(3):
        for x in range(6):
            other[c, x] = piece[c, x]


@njit(cache=True)
def longest_side(piece: np.ndarray) -> int:
    """Return the number of the longest side, from corner s to s + 1, or -1 where no side spans more than a voxel."""
    found, most, span = -1, 0.0, 0.0
    for s in range(3):
        length = 0.0
        for x in range(3):
            reach = abs(piece[(s + 1) % 3, x] - piece[s, x])
            span = max(span, reach)
            length += reach * reach
        if length > most:
            found, most = s, length
    return found if span > 1.0 else -1


@njit(cache=True)
def halve(piece: np.ndarray, s: int, other: np.ndarray) -> None:
    """Cut a piece, in place, at the middle of its side s, and put the other half into `other`."""
    a = s
    b = (s + 1) % 3
    for x in range(6):
        middle = 0.5 * (piece[a, x] + piece[b, x])
        for c in range(3):
            other[c, x] = piece[c, x]
        piece[b, x] = middle
        other[a, x] = middle


@njit(cache=True)
def class_of(piece: np.ndarray, marks: np.ndarray) -> int:
    """Return HIDDEN if all samples of the voxels that contain a piece are inside, LOST if all are outside.

    A piece that lies on samples is contained in the voxels on both sides.
    """
    outside = inside = False
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for x in range(3):
        low[x] = int(np.floor(min(piece[0, x], piece[1, x], piece[2, x]) - TOUCH))
        high[x] = int(np.ceil(max(piece[0, x], piece[1, x], piece[2, x]) + TOUCH))
    for i in range(low[0], high[0] + 1):
        for j in range(low[1], high[1] + 1):
            for k in range(low[2], high[2] + 1):
                if marks[i, j, k] & OUTSIDE:
                    outside = True
                else:
                    inside = True
    if outside:
        return BACKED if inside else LOST
    return HIDDEN


@njit(cache=True)
def area(piece: np.ndarray) -> float:
    """Return the area of a triangle [voxel^2]."""
    ax, ay, az = piece[1, 0] - piece[0, 0], piece[1, 1] - piece[0, 1], piece[1, 2] - piece[0, 2]
    bx, by, bz = piece[2, 0] - piece[0, 0], piece[2, 1] - piece[0, 1], piece[2, 2] - piece[0, 2]
    return 0.5 * np.sqrt((ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + (ax * by - ay * bx) ** 2)


CELLS = 96.0  # samples of the flood along the longest side of the mesh
CLEAR = 0.1  # share of the area of a part, seen from outside, from which its side is known
MOST = 0.9  # share of the area of known parts that faces inward from which the file is inside out, as a mirrored one is


def turned_outward(body: Body) -> Body:
    """Return the body with all triangles facing outward; warns of how many did not."""
    turned = facing_inward(body.mesh)
    if not turned.any():
        return body
    count = f"{turned.sum():,} of {len(turned):,}"
    warnings.warn(f"{count} triangles of the body face inward: they are turned outward", stacklevel=2)
    return replace(body, mesh=turn(body.mesh, turned))


def turn(mesh: Mesh, turned: np.ndarray) -> Mesh:
    """Return the mesh with the winding of some triangles, (m,) bool, reversed."""
    triangles = np.where(turned[:, None], mesh.triangles[:, [0, 2, 1]], mesh.triangles)
    uv = None if mesh.uv is None else np.where(turned[:, None, None], mesh.uv[:, [0, 2, 1]], mesh.uv)
    return replace(mesh, triangles=triangles, uv=uv)


def facing_inward(mesh: Mesh) -> np.ndarray:
    """Return which triangles face inward, (m,) bool.

    Triangles that share an edge with no third one belong to one part, and face one side of it. The outer side of a part
    bulges, and has more area with the outside of the mesh in front and its inside behind, as a flood from outside finds
    them. Where the two disagree, or the flood finds no such area, as for a sheet or what lies within the body, the part
    faces where most of it does in the file, or away from there if the file as a whole is inside out. One with a single
    side, as a Moebius strip, is left alone.
    """
    points, same = np.unique(mesh.points, axis=0, return_inverse=True)  # joined along the seams of textures
    merged = Mesh(points, same.reshape(-1)[mesh.triangles].astype(np.int32))
    vectors = area_vectors(merged)
    areas = np.linalg.norm(vectors, axis=1)
    count = len(areas)
    sides = two_sides(merged.triangles)
    own, other = sides[:count], sides[count:]

    def on_sides(values: np.ndarray) -> np.ndarray:
        """Sum values of triangles, which are opposite on the other side, over the side of each."""
        return (np.bincount(own, values, 2 * count) - np.bincount(other, values, 2 * count))[own]

    facing = np.bincount(own, areas, 2 * count)
    front = facing[own]
    whole = front + facing[other]
    seen = on_sides(areas * seen_sides(merged, normalized(vectors)))
    parts = np.minimum(own, other)
    middles = merged.points[merged.triangles].mean(axis=1)
    sums = [np.bincount(parts, areas * middles[:, axis], 2 * count) for axis in range(3)]
    total = np.maximum(np.bincount(parts, areas, 2 * count), np.finfo(float).tiny)
    centres = np.stack(sums, axis=1) / total[:, None]
    bulge = on_sides(np.einsum("tx,tx->t", middles - centres[parts], vectors) / 3.0)  # volumes of cones to the middle
    sure = (np.abs(seen) > CLEAR * whole) & (np.sign(seen) == np.sign(bulge))
    fewer = np.where(2.0 * front == whole, own > other, 2.0 * front < whole)
    inside_out = areas[sure & (seen < 0.0)].sum() > MOST * areas[sure].sum()
    return (own != other) & np.where(sure, seen < 0.0, fewer ^ inside_out)


def two_sides(triangles: np.ndarray) -> np.ndarray:
    """Number the sides of parts, (2 m,) int32: those of triangles (m, 3) as they are, then of reversed ones."""
    corners = triangles.astype(np.int64)  # products of two vertex numbers do not fit into 32 bits
    tails = corners.ravel()
    heads = np.roll(corners, -1, axis=1).ravel()
    edges = np.minimum(tails, heads) * (corners.max() + 1) + np.maximum(tails, heads)
    order = np.argsort(edges, kind="stable")
    starts = np.flatnonzero(np.diff(edges[order], prepend=-1))
    pairs = starts[np.diff(starts, append=len(order)) == 2]
    first = order[pairs]
    second = order[pairs + 1]
    alike = (tails[first] == heads[second]) & (tails[first] != heads[first])
    count = len(corners)
    a, b = first // 3, second // 3
    rows = np.concatenate([a, a + count])
    columns = np.concatenate([np.where(alike, b, b + count), np.where(alike, b + count, b)])
    links = coo_array((np.ones(len(rows), bool), (rows, columns)), (2 * count, 2 * count))
    return connected_components(links, directed=False)[1]


def seen_sides(mesh: Mesh, normals: np.ndarray) -> np.ndarray:
    """Return 1 where only the front of a triangle is outside, -1 where only its back is, else 0, (m,) int."""
    middles = mesh.points[mesh.triangles].mean(axis=1)
    voxel = float(np.ptp(mesh.points, axis=0).max()) / CELLS
    if voxel == 0.0:
        return np.zeros(len(middles), np.int64)
    edges, uses = edge_uses(mesh.triangles)
    whole = capped(mesh, holes(edges[uses % 2 == 1], mesh.points))
    lattice = lattice_around(whole.points[whole.triangles], voxel, 2.0)
    marks = marked_samples(whole.points[whole.triangles], lattice)

    def outside(places: np.ndarray) -> np.ndarray:
        i, j, k = np.rint(places / voxel - lattice.first).astype(np.int64).T
        return (marks[i, j, k] & OUTSIDE) > 0

    return outside(middles + voxel * normals).astype(np.int64) - outside(middles - voxel * normals)
