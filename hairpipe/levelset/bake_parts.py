"""Bake a body as one level set for each group of bones, in the frame of the bones.

Cutting of a body's skin into parts: closed patches that overlap their neighbours a little.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple
from warnings import warn

import numpy as np

from hairpipe.body.groups import Groups, group_bones, group_weights
from hairpipe.body.skinning import skin
from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import wide_triangles
from hairpipe.levelset.bake import bake_surface
from hairpipe.levelset.closed_surface import Hole, Surface, capped, describe, openings
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.values import Body, BodyParts, LevelSet, Mesh, Pose
from hairpipe.values.body import gathered

# A cap runs straight from its rim towards the middle of the hole for this share of the way, and only then into the
# neighbour, by so many radii of the hole. A cone from the rim on comes out of the skin where that is hollow: by 2.8 mm
# at the throat of our bust. Flat caps leave 4 % of MakeHuman's body hollow, where three parts meet; these a thousandth.
COLLAR, REACH = 0.2, 1.0


class Cut(NamedTuple):
    """A patch of the skin that belongs to a group of bones.

    group      index of the group
    vertices   vertices of the body in the patch, (k,) int64
    triangles  triangles between them, indices into `vertices`, (m, 3) int32
    rim        vertices on open edges of the body itself, (k,) bool
    """

    group: int
    vertices: np.ndarray
    triangles: np.ndarray
    rim: np.ndarray


class Edges(NamedTuple):
    """The edge graph of a skin. Coincident vertices count as one: skins are split along the seams of their texture.

    places   node of every vertex, (n,) int64
    ends     nodes at the ends of the edges, (e, 2) int64
    lengths  lengths of the edges [m], (e,) float64
    """

    places: np.ndarray
    ends: np.ndarray
    lengths: np.ndarray


def cut_skin(body: Body, groups: Groups, overlap: float) -> list[Cut]:
    """Return the patches of all groups that have skin; pure.

    overlap  extension of a patch along the skin beyond the vertices with the largest weight of its group [m]

    Two bones share the skin where both have weight 1/2. Skin shared by more than two belongs to the first of them, so
    that no skin is omitted.
    """
    owners = group_weights(body, groups).argmax(axis=1)
    skin = edges_along(body.mesh)
    rim = rim_of(body.mesh, skin)
    return [patch(body.mesh, skin, rim, group, owners == group, overlap) for group in np.unique(owners).tolist()]


def rim_of(mesh: Mesh, skin: Edges) -> np.ndarray:
    """Return which vertices are on open edges, (n,) bool; pure. Warns of these, since they will be capped."""
    open_places = np.zeros(skin.places.max() + 1, bool)
    found, _ = openings(mesh)
    for hole in found:
        open_places[skin.places[hole.loop]] = True
    if found:
        warn(f"body: capped {describe(found)}", stacklevel=2)
    return open_places[skin.places]


def patch(mesh: Mesh, skin: Edges, rim: np.ndarray, group: int, own: np.ndarray, overlap: float) -> Cut:
    """Return the patch of the vertices that are its own, (n,) bool, and of all within a distance [m] from those."""
    kept = mesh.triangles[near_along(skin, own, overlap)[mesh.triangles].any(axis=1)]
    vertices, triangles = np.unique(kept, return_inverse=True)
    return Cut(group, vertices, triangles.reshape(-1, 3).astype(np.int32), rim[vertices])


def edges_along(mesh: Mesh) -> Edges:
    """Return the edges of a mesh; pure."""
    points, places = np.unique(mesh.points, axis=0, return_inverse=True)
    places = places.reshape(-1)
    ends = np.sort(places[mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)], axis=1)
    ends = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    return Edges(places, ends, np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1))


def near_along(skin: Edges, own: np.ndarray, reach: float) -> np.ndarray:
    """Return which vertices are within a distance [m] of some, (n,) bool, along the edges, (n,) bool; pure."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    size = skin.places.max() + 1
    graph = coo_array((skin.lengths, (skin.ends[:, 0], skin.ends[:, 1])), shape=(size, size)).tocsr()
    distances = dijkstra(graph, directed=False, indices=np.unique(skin.places[own]), limit=reach, min_only=True)
    return np.isfinite(distances)[skin.places]


def closed(points: np.ndarray, triangles: np.ndarray, rim: np.ndarray) -> Mesh:
    """Return a patch closed by caps across its holes, static; pure.

    rim  vertices on open edges of the body itself, (n,) bool

    At a cut the cap is a hat: a collar across a limb, and a cone inside the adjacent part.
    """
    mesh = Mesh(points, triangles, np.zeros_like(points))
    found = openings(mesh)[0]
    cut = [not rim[hole.loop].any() for hole in found]
    tall = [raised(mesh, hole) if here else hole for here, hole in zip(cut, found, strict=True)]
    for number in np.flatnonzero(cut):
        mesh, loop = collared(mesh, found[number])
        tall[number] = tall[number]._replace(loop=loop)
    return capped(mesh, tall)


def collared(mesh: Mesh, hole: Hole) -> tuple[Mesh, np.ndarray]:
    """Return the mesh with a hole narrowed by a flat collar, and the loop that is left open, (k,); pure."""
    here = hole.loop
    ahead = np.roll(hole.loop, -1)
    ring = mesh.points[here] + COLLAR * (hole.centre - mesh.points[here])
    inner = len(mesh.points) + np.arange(len(here))
    next_inner = np.roll(inner, -1)
    collar = np.concatenate([np.stack([ahead, here, inner], 1), np.stack([ahead, inner, next_inner], 1)])
    points = np.concatenate([mesh.points, ring])
    triangles = np.concatenate([mesh.triangles, collar.astype(np.int32)])
    return Mesh(points, triangles, np.zeros_like(points)), inner


def raised(mesh: Mesh, hole: Hole) -> Hole:
    """Return a hole with its middle moved outwards, away from the skin that ends there; pure."""
    here = mesh.points[hole.loop]
    ahead = np.roll(mesh.points[hole.loop], -1, axis=0)
    area = 0.5 * np.cross(ahead - hole.centre, here - hole.centre).sum(axis=0)
    size = float(np.linalg.norm(area))
    if size == 0.0:
        return hole
    edges = {tuple(edge) for edge in mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
    loop = hole.loop.tolist()
    along = sum((b in edges) - (b[::-1] in edges) for b in zip(loop, loop[1:] + loop[:1], strict=True))
    return hole._replace(centre=hole.centre + np.sign(along) * REACH * np.sqrt(size / np.pi) * area / size)


# Along the skin beyond the middle between two bones, in voxels: the caps lie inside the neighbour, where none touches.
OVERLAP = 3.0
# Local vertices are rounded to this many steps in a metre: what is rigid in its frame has the same bytes at all frames.
STEPS = 2.0**20
REMEMBERED = 64
# Of the area of a part, without a word: caps, which lie inside neighbours, lose up to 3 % of MakeHuman's at 5 to 20 mm.
LOST = 0.05


def bake_parts(rest: Body, pose: Pose | None, voxel: float, half_width: float, smallest: float) -> BodyParts:
    """Return the parts of a body in a pose; without a pose, at rest and static. Pure.

    voxel       spacing of the samples [m]
    half_width  half width of the band, in voxels
    smallest    minimum size of a part of the skin [m]; bones with less move with their parents

    The skin of a part is the posed one: skin shared by neighbours is bent in the frames of both. Raises BadInput as
    `skin` and, naming the part, `bake` do, and warns of parts that are too thin for the voxel.
    """
    points = skin(rest, pose).points
    groups = group_bones(rest, smallest)
    cuts = cut_skin(rest, groups, OVERLAP * voxel)
    poses, rates = frames_of(rest, pose, groups.leaders[[cut.group for cut in cuts]])
    names = (*rest.skeleton.names, "body")  # the last is led by none, -1
    labels = tuple(names[groups.leaders[cut.group]] for cut in cuts)
    found, lost = [], []
    for label, cut, place in zip(labels, cuts, poses, strict=True):
        try:
            part, share = bake_part(cut, points, place, voxel, half_width)
        except BadInput as error:
            right = f"{error.right}; with a larger `smallest` small parts join their parents"
            raise BadInput(error.what, where=f"{error.where}, part {label}", right=right) from error
        found.append(part)
        lost += [label] * (share > LOST)
    if lost:
        thin = f"more than {LOST:.0%} of {', '.join(lost)}"
        warn(f"body: {thin} is too thin for voxel = {voxel:g} m, and does not stop hair", stacklevel=2)
    return gathered(labels, poses, rates, found)


def frames_of(rest: Body, pose: Pose | None, leaders: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the frames of bones, [R | p] [m] and its rate, (G, 3, 4) each, R being the rotation since rest; pure.

    leaders  the bones, (G,), whose joints are p; -1: no bone, with the frame of the world
    """
    poses = np.tile(np.eye(3, 4), (len(leaders), 1, 1))
    rates = np.zeros((len(leaders), 3, 4))
    has_leader = leaders >= 0
    bones = rest.skeleton.rest[leaders[has_leader]]
    poses[has_leader] = bones[:, :3]
    if pose is not None:
        poses[has_leader], rates[has_leader] = (
            pose.transforms[leaders[has_leader], :3],
            pose.rates[leaders[has_leader], :3],
        )
    unbind = np.swapaxes(bones[:, :3, :3], 1, 2)
    poses[has_leader, :, :3] = poses[has_leader, :, :3] @ unbind
    rates[has_leader, :, :3] = rates[has_leader, :, :3] @ unbind
    return poses, rates


def bake_part(
    cut: Cut, points: np.ndarray, place: np.ndarray, voxel: float, half_width: float
) -> tuple[LevelSet, float]:
    """Return the level set of a part in its own frame, and the share of its area that is too thin for the voxel.

    points  points of the posed skin [m], (n, 3) float64
    place   [R | p] of the part [m], (3, 4) float64
    """
    local = (points[cut.vertices] - place[:, 3]) @ place[:, :3]
    rounded = np.round(local * STEPS) / STEPS + 0.0
    return bake_once(rounded.tobytes(), cut.triangles.tobytes(), cut.rim.tobytes(), voxel, half_width)


@lru_cache(maxsize=REMEMBERED)
def bake_once(points: bytes, triangles: bytes, rim: bytes, voxel: float, half_width: float) -> tuple[LevelSet, float]:
    """Return the level set of an open patch, closed by caps, without velocities; see `closed`, `bake_surface`."""
    patch = np.frombuffer(points).reshape(-1, 3), np.frombuffer(triangles, np.int32).reshape(-1, 3)
    mesh = closed(*patch, np.frombuffer(rim, bool))
    surface = Surface(mesh.points[mesh.triangles], np.zeros((len(mesh.triangles), 3, 3)))
    wide_triangles(surface.corners)
    found, lost = bake_surface(surface, lattice_around(surface.corners, voxel, half_width), half_width)
    return replace(found, velocity=np.empty((0, *found.velocity.shape[1:]), np.float32)), lost
