"""A groom of one head on another: places of the new skin that correspond to the roots, turns of segments, and lengths.

A root goes to the place of the same vertices, of the same texture coordinates, or nearest to it once the heads are
aligned. Each correspondence is an affine map F of the tangent plane, with normal to normal, whose rotation is the polar
factor of F (Higham, Computing the polar decomposition, 1986). These rotations are averaged over the triangles at a
vertex and interpolated over the skin, so that strands of a clump turn alike.

A segment turns as the skin next to it does, so that hair that lies on one head lies on the other. Farther from the skin
it turns as the head on average, so that hanging hair hangs. Lengths are exact, as segments are only turned.
"""

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import root_frames
from hairpipe.geometry.simd import lane, number
from hairpipe.geometry.solid import solid_of
from hairpipe.geometry.triangle_tree import Tree, closest_on_triangle, nearest_sites, squares_to_box, tree_over
from hairpipe.geometry.vec3 import row
from hairpipe.groom.binding import bind_tips
from hairpipe.groom.growing import GAP, closed, depths, keep_strands_out
from hairpipe.levelset.closed_surface import edge_uses, holes
from hairpipe.values import Body, Groom, Mesh
from hairpipe.values.painting import maps_at, vertex_coat
from hairpipe.values.strand_arrays import name_strands, take
from hairpipe.values.triangles import Sites, in_lowest_triangle, site_points, site_uv, sum_at_vertices, unit_normals

By = Literal["vertices", "uv", "surface"]
Landmarks = tuple[tuple[float, float, float, float, float, float], ...]
UV_ERROR = 1e-3  # distance in texture coordinates that still is on a triangle: islands are a little larger or smaller
FACING = 0.5  # cosine between the aligned normal and that of the nearest place from which both are of one side
NEAR = 0.03  # distance of an aligned place from the new skin up to which both correspond in direction [m]
LYING, HANGING = 0.01, 0.06  # distances from the skin up to which a segment turns with it, and beyond which not [m]
TORN = 4.0  # times the distance of neighbouring roots, at which they are no neighbours on the new head
BENT = 30.0  # turn of a segment out of the new head that is reported [deg]
INSIDE = 1e-5  # depth that is reported [m]
TIP_REACH = 0.02  # distance of held tips from the new skin that is reported [m]
SCALP = 0.5  # value of the map "scalp" at the hairline


class Match(NamedTuple):
    """Places of the new head that correspond to places of the old one, (k,).

    sites     on the new mesh
    known     whether there is one, (k,) bool
    turns     rotation of the skin from the old place to the new one, (k, 3, 3); 0 where it is not known
    ratios    area of the new skin over that of the old, (k,); 0 where it is not known
    mirrored  whether texture coordinates run clockwise on one head only, (k,) bool
    several   whether texture coordinates belong to several places of the new head, (k,) bool
    """

    sites: Sites
    known: np.ndarray
    turns: np.ndarray
    ratios: np.ndarray
    mirrored: np.ndarray
    several: np.ndarray


Correspondence = Callable[[Sites], Match]


def rotation_nearest_to(matrices: np.ndarray) -> np.ndarray:
    """Return the rotations nearest to matrices, (..., 3, 3): their polar factors, where these are rotations; pure."""
    left, _, right = np.linalg.svd(matrices)
    left[..., :, 2] *= np.linalg.det(left @ right)[..., None]
    return left @ right


def match_of(sites: Sites, known: np.ndarray, old: np.ndarray, new: np.ndarray) -> Match:
    """Return the match of sites whose tangent vectors correspond, old and new, (k, 2, 3) [m] each; pure.

    known  whether they do, (k,) bool; turns are not known either of triangles without area
    """
    across = [np.cross(pair[:, 0], pair[:, 1]) for pair in (old, new)]
    areas = [np.linalg.norm(vectors, axis=1) for vectors in across]
    flat = np.flatnonzero(known & (areas[0] > 0.0) & (areas[1] > 0.0))
    frames = [
        np.concatenate([pair[flat], vectors[flat, None] / area[flat, None, None]], axis=1)
        for pair, vectors, area in zip((old, new), across, areas, strict=True)
    ]
    turns = np.zeros((len(known), 3, 3))
    ratios = np.zeros(len(known))
    turns[flat] = rotation_nearest_to(np.swapaxes(np.linalg.solve(*frames), 1, 2))
    ratios[flat] = areas[1][flat] / areas[0][flat]
    nowhere = np.zeros_like(known)
    return Match(sites, ~nowhere, turns, ratios, nowhere, nowhere)


def edges_of(mesh: Mesh, triangles: np.ndarray) -> np.ndarray:
    """Return two edges of some triangles, from their first corner on [m], (k, 2, 3)."""
    corners = mesh.points[mesh.triangles[triangles]]
    return corners[:, 1:] - corners[:, :1]


def by_vertices(source: Mesh, target: Mesh) -> Correspondence:
    """Return the correspondence of meshes of the same triangles; BadInput where these differ."""
    if not np.array_equal(source.triangles, target.triangles):
        sizes = [f"{len(mesh.triangles):,} triangles, {len(mesh.points):,} vertices" for mesh in (source, target)]
        what = f"the heads have other triangles: {sizes[0]}, and {sizes[1]}"
        raise BadInput(what, where="by", right='meshes that differ in their points only, or by = "uv" or "surface"')

    def match_at(sites: Sites) -> Match:
        pairs = (edges_of(mesh, sites.triangles) for mesh in (source, target))
        return match_of(sites, np.ones(len(sites.triangles), bool), *pairs)

    return match_at


def by_uv(source: Mesh, target: Mesh, align: Callable[[np.ndarray], np.ndarray]) -> Correspondence:
    """Return the correspondence of equal texture coordinates; of several places, that nearest to the aligned one.

    Raises BadInput where a mesh has no texture coordinates.
    """
    if source.uv is None or target.uv is None:
        which = "source" if source.uv is None else "target"
        right = 'texture coordinates, or by = "surface"'
        raise BadInput(f"the {which} has no texture coordinates", where=f"in.{which}", right=right)
    flat = np.concatenate([target.uv.astype(float), np.zeros((*target.triangles.shape, 1))], axis=2)
    tree = tree_over(flat)
    old, new = (np.moveaxis(gradients(mesh, mesh.uv), 2, 1) for mesh in (source, target) if mesh.uv is not None)
    signs = [uv_signs(mesh.uv) for mesh in (source, target) if mesh.uv is not None]

    def match_at(sites: Sites) -> Match:
        count = len(sites.triangles)
        places = np.column_stack([site_uv(source, sites).astype(float), np.zeros(count)])
        found = Sites(np.full(count, -1, np.int32), np.zeros((count, 3)))
        several = np.zeros(count, bool)
        aligned = np.ascontiguousarray(align(site_points(source, sites)))
        corners = target.points[target.triangles]
        find_containing(tree, corners, places, aligned, *found, several)
        known = found.triangles >= 0
        found = Sites(np.where(known, found.triangles, 0).astype(np.int32), found.barycentrics)
        mirrored = known & (signs[0][sites.triangles] != signs[1][found.triangles])
        match = match_of(found, known & ~mirrored, old[sites.triangles], new[found.triangles])
        return match._replace(known=known, mirrored=mirrored, several=several)

    return match_at


def uv_signs(uv: np.ndarray) -> np.ndarray:
    """Return whether texture coordinates of triangles, (m, 3, 2), run counter-clockwise, (m,) bool."""
    a, b = np.moveaxis((uv[:, 1:] - uv[:, :1]).astype(float), 1, 0)
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0.0


def gradients(mesh: Mesh, uv: np.ndarray) -> np.ndarray:
    """Return the change of the place over u and v in every triangle [m], (m, 3, 2); 0 in those without area there."""
    corners = mesh.points[mesh.triangles]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    steps = np.swapaxes((uv[:, 1:] - uv[:, :1]).astype(float), 1, 2)
    wide = np.abs(np.linalg.det(steps)) > 0.0
    found = np.zeros_like(edges)
    found[wide] = edges[wide] @ np.linalg.inv(steps[wide])
    return found


@njit(cache=True, parallel=True)
def find_containing(
    tree: Tree,
    corners: np.ndarray,
    places: np.ndarray,
    wanted: np.ndarray,
    triangles: np.ndarray,
    barycentrics: np.ndarray,
    several: np.ndarray,
) -> None:
    """Write the triangle of a tree over texture coordinates that contains each place, and where in it, in place.

    corners  of the triangles in space [m], (m, 3, 3)
    places   texture coordinates, third 0, (k, 3)
    wanted   of several places the nearest to this one in space is chosen [m], (k, 3)
    several  whether there are some, apart by more than the error of texture coordinates, (k,) bool

    A place just off all triangles is on the nearest one; without any triangle within UV_ERROR nothing is written.
    """
    leaves = len(tree.starts) - 1
    for i in prange(len(places)):
        p = row(places, i)
        waiting = np.ones(128, np.int64)
        count = 1
        least = UV_ERROR * UV_ERROR
        way = np.inf
        here = np.zeros(3)
        chosen = np.zeros(3)
        while count > 0:
            count -= 1
            box = waiting[count]
            if number(squares_to_box(tree.boxes, box, (lane(p[0]), lane(p[1]), lane(p[2])))) > least:
                continue
            if box < leaves:
                waiting[count], waiting[count + 1] = 2 * box, 2 * box + 1
                count += 2
                continue
            for place in range(tree.starts[box - leaves], tree.starts[box - leaves + 1]):
                squared, weights = closest_on_triangle(tree.corners, place, p)
                squared = squared if squared > 1e-14 else 0.0  # the rounding of single precision
                if squared > least:
                    continue
                t = tree.triangles[place]
                far = 0.0
                for x in range(3):
                    here[x] = 0.0
                    for k in range(3):
                        here[x] += weights[k] * corners[t, k, x]
                    far += (here[x] - wanted[i, x]) ** 2
                if squared == least and way < np.inf:
                    apart = 0.0
                    for x in range(3):
                        apart = max(apart, abs(here[x] - chosen[x]))
                    several[i] = several[i] or (squared == 0.0 and apart > 1e-4)
                if squared < least or far < way:
                    if squared < least:
                        several[i] = False
                    least, way = squared, far
                    triangles[i] = t
                    for k in range(3):
                        barycentrics[i, k] = weights[k]
                        chosen[k] = here[k]


def by_surface(source: Mesh, target: Mesh, align: Callable[[np.ndarray], np.ndarray]) -> Correspondence:
    """Return the correspondence of aligned places to the nearest of the new head.

    Turns are not known where the nearest place faces another way, or is farther than NEAR.
    """
    shift = align(np.zeros((1, 3)))

    def match_at(sites: Sites) -> Match:
        found, distances = nearest_sites(target, align(site_points(source, sites)))
        old = edges_of(source, sites.triangles)
        new = align(old.reshape(-1, 3)).reshape(-1, 2, 3) - shift
        normals = unit_normals(target)[found.triangles]
        turned = np.cross(new[:, 0], new[:, 1])
        facing = np.sum(turned * normals, axis=1) > FACING * np.linalg.norm(turned, axis=1)
        facing &= distances <= NEAR
        new = new - np.sum(new * normals[:, None], axis=2, keepdims=True) * normals[:, None]
        return match_of(found, facing, old, new)

    return match_at


def alignment(source: Body, target: Body, landmarks: Landmarks) -> Callable[[np.ndarray], np.ndarray]:
    """Return the map of places of one head to the other, (k, 3) to (k, 3) [m].

    By pairs of landmarks it is the similarity of least squares (Umeyama 1991); without them it takes the extent of the
    map "scalp" along the axes to that of the other, or that of the meshes where neither body has this map.

    Raises BadInput for one or two landmarks, for landmarks on a line, and where only one body has the map.
    """
    if landmarks:
        pairs = np.array(landmarks).reshape(-1, 2, 3)
        old, new = pairs[:, 0], pairs[:, 1]
        apart = old - old.mean(axis=0)
        if len(pairs) < 3 or np.linalg.svd(apart, compute_uv=False)[1] < 1e-6:
            raise BadInput(
                f"{len(pairs)} landmarks, or all on a line", where="landmarks", right="3 or more, in a plane"
            )
        spread = (new - new.mean(axis=0)).T @ apart
        turn = rotation_nearest_to(spread)
        size = np.sum(turn * spread) / np.sum(apart**2)
        return lambda points: size * (points - old.mean(axis=0)) @ turn.T + new.mean(axis=0)
    boxes = []
    bare = ["scalp" not in body.maps for body in (source, target)]
    if bare[0] != bare[1]:
        which = "source" if bare[0] else "target"
        what = f'the {which} has no map "scalp", by the extent of which heads are aligned'
        raise BadInput(what, where=f"in.{which}", right="scalp = {} of load_body, or landmarks")
    for body in (source, target):
        points = body.mesh.points if bare[0] else body.mesh.points[body.maps["scalp"] > SCALP]
        if not len(points):
            raise BadInput('the map "scalp" is empty', where="in.source, in.target", right="a scalp, or landmarks")
        boxes.append((points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-9)))
    (low, size), (new_low, new_size) = boxes
    return lambda points: (points - low) * (new_size / size) + new_low


class Turning(NamedTuple):
    """Rotation of the old skin to the new one: at the vertices of the old mesh, (n, 3, 3), and on average, (3, 3)."""

    vertices: np.ndarray
    average: np.ndarray

    def at(self, mesh: Mesh, sites: Sites) -> np.ndarray:
        """Return the rotations at sites of the old mesh, (k, 3, 3)."""
        corners = self.vertices[mesh.triangles[sites.triangles]]
        return rotation_nearest_to(np.einsum("kc,kcij->kij", sites.barycentrics, corners))


def turning_of(mesh: Mesh, correspond: Correspondence, roots: Match) -> Turning:
    """Return the turning of a mesh by its correspondence at the middles of its triangles."""
    count = len(mesh.triangles)
    middles = Sites(np.arange(count, dtype=np.int32), np.full((count, 3), 1.0 / 3.0))
    average = rotation_nearest_to(roots.turns.sum(axis=0)) if roots.turns.any() else np.eye(3)
    areas = np.linalg.norm(np.cross(*np.moveaxis(edges_of(mesh, middles.triangles), 1, 0)), axis=1)
    weighted = areas[:, None, None] * correspond(middles).turns
    sums = np.stack([sum_at_vertices(mesh, weighted[:, None, k]) for k in range(3)], axis=1)
    unknown = ~(np.abs(sums).max(axis=(1, 2)) > 0.0)
    sums[unknown] = average
    return Turning(rotation_nearest_to(sums), average)


def transferred(
    groom: Groom, source: Body, target: Body, by: By, lengths: Literal["kept", "scaled"], landmarks: Landmarks = ()
) -> Groom:
    """Return the groom of a head on another one, with ids, groups and all else that its strands carry; pure.

    lengths    kept, or scaled by the root of the ratio of areas of skin at the roots
    landmarks  pairs of places of both heads [m], see `alignment`

    Warnings count strands that are left out, and those of doubtful places. Raises BadInput where the heads do not
    correspond, and if the groom is of another body.
    """
    mesh, new = source.mesh, target.mesh
    if groom.root_triangles.max(initial=-1) >= len(mesh.triangles):
        raise BadInput("the groom grows on another body", where="in.source", right="the body of the groom")
    if landmarks and by == "vertices":
        raise BadInput('landmarks with by = "vertices"', where="landmarks", right='by = "surface" or "uv"')
    sites = Sites(groom.root_triangles, groom.root_barycentrics)
    if by == "vertices":
        correspond = by_vertices(mesh, new)
    else:
        correspond = {"uv": by_uv, "surface": by_surface}[by](mesh, new, alignment(source, target, landmarks))
    match = correspond(sites)
    if not match.known.all():
        groom, sites, match = without_unknown(groom, sites, match)
    turning = turning_of(mesh, correspond, match)
    ratios = match.ratios[match.ratios > 0.0]
    size = float(np.sqrt(ratios.mean())) if len(ratios) else 1.0
    scale = size if lengths == "scaled" else 1.0
    found = in_lowest_triangle(new, match.sites)
    frames = root_frames(new.points, new.triangles, *found)
    roots = groom.points[groom.offsets[:-1]]
    off = np.einsum("sij,sj->si", turning.at(mesh, sites), roots - site_points(mesh, sites))
    off[np.sum(off * frames[:, :, 2], axis=1) < 0.0] = 0.0  # a root under the old skin is on the new one
    placed = turned_segments(groom, mesh, turning, frames[:, :, 3] + scale * off, scale)
    points = placed.copy()
    solid = solid_of(closed(new))
    keep_strands_out(*solid, points, groom.offsets, GAP * min(scale, 1.0))
    report(groom.ids, match, scalp_at(target, found), torn(roots, points[groom.offsets[:-1]], size))
    report_bodies(new, groom, placed, points, depths(*solid, points))
    moved = replace(
        groom,
        points=points,
        root_triangles=found.triangles,
        root_barycentrics=found.barycentrics,
        root_frames=frames,
        root_uv=groom.root_uv if new.uv is None else site_uv(new, found),
        maps=maps_at(target, found) | groom.maps,
        tip_triangles=None,
        tip_barycentrics=None,
        tip_frames=None,
    )
    held = None if groom.tip_triangles is None else groom.tip_triangles >= 0
    return moved if held is None else bind_tips(new, moved, held, TIP_REACH)


def without_unknown(groom: Groom, sites: Sites, match: Match) -> tuple[Groom, Sites, Match]:
    """Return all without the strands that have no place on the new head, with a warning; BadInput if none has one."""
    kept = np.flatnonzero(match.known)
    if not len(kept):
        what = "the texture coordinates of all roots are unused on the new head"
        raise BadInput(what, where="by", right='heads with one layout of texture coordinates, or by = "surface"')
    gone = groom.ids[~match.known]
    why = "the new head lacks the texture coordinates of their roots"
    message = f'{len(gone)} strands are left out, as {why}: {name_strands(gone)} (by = "surface")'
    warnings.warn(message, stacklevel=3)
    left = Match(Sites(*(array[kept] for array in match.sites)), *(array[kept] for array in match[1:]))
    return take(groom, kept), Sites(*(array[kept] for array in sites)), left


def turned_segments(groom: Groom, mesh: Mesh, turning: Turning, roots: np.ndarray, scale: float) -> np.ndarray:
    """Return strands from new roots [m], (S, 3), on, whose segments are turned and scaled [m], (P, 3); pure."""
    ways = np.diff(groom.points, axis=0)
    sites, distances = nearest_sites(mesh, groom.points[:-1] + 0.5 * ways)
    here = np.clip((distances - LYING) / (HANGING - LYING), 0.0, 1.0)
    hanging = (here * here * (3.0 - 2.0 * here))[:, None, None]
    turns = rotation_nearest_to((1.0 - hanging) * turning.at(mesh, sites) + hanging * turning.average)
    steps = scale * np.einsum("pij,pj->pi", turns, ways)
    steps[groom.offsets[1:-1] - 1] = 0.0  # from tips to roots
    along = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return along + np.repeat(roots - along[groom.offsets[:-1]], np.diff(groom.offsets), axis=0)


def torn(old: np.ndarray, new: np.ndarray, size: float) -> np.ndarray:
    """Return which roots, (S, 3) [m] on both heads, lie far from their nearest neighbour of the old one, (S,) bool."""
    if len(old) < 2:
        return np.zeros(len(old), bool)
    from scipy.spatial import KDTree

    near, neighbours = (np.asarray(found)[:, 1] for found in KDTree(old).query(old, 2))
    apart = np.linalg.norm(new - new[neighbours], axis=1)
    return apart > TORN * size * np.maximum(near, np.median(near))


def scalp_at(body: Body, sites: Sites) -> np.ndarray:
    """Return whether sites are on the scalp, (k,) bool; all are where the body has no map of it."""
    whole = np.ones(len(sites.triangles), bool)
    return vertex_coat(body, "scalp", "in.target")(sites) > 0.0 if "scalp" in body.maps else whole


def report(ids: np.ndarray, match: Match, on_scalp: np.ndarray, apart: np.ndarray) -> None:
    """Warn of strands with doubtful places on the new head."""
    far = f"end more than {TORN:g} times as far from their neighbours, at seams or ends of islands"
    doubts = (
        (match.several, "have texture coordinates of several places, of which the nearest is used", 'by = "surface"'),
        (match.mirrored, "have mirrored texture coordinates, and turn as the others on average", 'by = "surface"'),
        (~on_scalp, 'grow outside of the map "scalp" of the new head', "one hairline on both heads, or landmarks"),
        (apart, far, "landmarks, or another correspondence"),
    )
    for which, what, right in doubts:
        if which.any():
            named = name_strands(ids[which])
            warnings.warn(f"{np.count_nonzero(which)} of {len(ids)} strands {what}: {named} ({right})", stacklevel=3)


def report_bodies(mesh: Mesh, groom: Groom, placed: np.ndarray, points: np.ndarray, deep: np.ndarray) -> None:
    """Warn of an open body, of strands bent by more than BENT out of it, and of points inside it by deep [m], (P,)."""
    edges, uses = edge_uses(mesh.triangles)
    loops = len(holes(edges[uses % 2 == 1], mesh.points))
    if loops:
        warnings.warn(f"the new head has {loops} holes, closed here: hair stays out of their caps", stacklevel=3)
    before, after = (np.diff(curve, axis=0) for curve in (placed, points))
    across = np.linalg.norm(np.cross(before, after), axis=1)
    angles = np.degrees(np.arctan2(across, np.sum(before * after, axis=1)))
    angles[groom.offsets[1:-1] - 1] = 0.0
    starts = groom.offsets[:-1]
    bent = np.maximum.reduceat(np.append(angles, 0.0), starts)
    if (bent > BENT).any():
        which = name_strands(groom.ids[bent > BENT])
        what = f"{np.count_nonzero(bent > BENT)} of {len(bent)} strands are bent by more than {BENT:g} degrees"
        warnings.warn(f"{what} out of the new head, up to {bent.max():.0f}: {which}", stacklevel=3)
    within = np.minimum.reduceat(deep, starts) < -INSIDE
    if within.any():
        what = f"{np.count_nonzero(within)} of {len(within)} strands are still inside the new head"
        warnings.warn(f"{what}, up to {-1e3 * deep.min():.2g} mm: {name_strands(groom.ids[within])}", stacklevel=3)
