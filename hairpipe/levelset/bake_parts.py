"""Bake a body as one level set for each group of bones that move as one, in the frame of the bones.

The skin is cut into parts: closed patches that overlap their neighbours a little.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple
from warnings import warn

import numpy as np

from hairpipe.body.skinning import skin
from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import wide_triangles
from hairpipe.levelset.bake import bake_surface
from hairpipe.levelset.closed_surface import Hole, Surface, capped, describe, openings
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.values import Body, BodyParts, LevelSet, Mesh, Pose
from hairpipe.values.body import gathered


class Groups(NamedTuple):
    leaders: np.ndarray  # joint whose frame each group has, (G,) int32
    members: np.ndarray  # group of every joint, (J,) int32


def group_bones(body: Body, smallest: float) -> Groups:
    """Return the groups that the joints of a body fall into, or one with leader -1 without joints; pure.

    smallest  diagonal of the box around the skin that follows a group more than any other joint [m]; a group whose skin
              is smaller, or absent, joins its parent's, from the finger tips inwards
    """
    parents = body.skeleton.parents
    if not len(parents):
        return Groups(np.array([-1], np.int32), np.zeros(0, np.int32))
    leader = np.arange(len(parents), dtype=np.int32)
    strongest = np.argmax(body.weights, axis=1)  # of equal ones the first
    nearest = np.take_along_axis(body.joints, strongest[:, None], axis=1)[:, 0]
    for joint in range(len(parents) - 1, -1, -1):
        covered = body.mesh.points[leader[nearest] == joint]
        small = not len(covered) or np.linalg.norm(np.ptp(covered, axis=0)) < smallest
        if parents[joint] >= 0 and small:
            leader[leader == joint] = parents[joint]
    leaders, members = np.unique(leader, return_inverse=True)
    return Groups(leaders.astype(np.int32), members.astype(np.int32))


def group_weights(body: Body, groups: Groups) -> np.ndarray:
    """Return the weight of every vertex in every group, (n, G) float64; pure."""
    weights = np.zeros((len(body.mesh.points), len(groups.leaders)))
    if not len(groups.members):
        return weights + 1.0
    rows = np.arange(len(weights))
    for joints, shares in zip(body.joints.T, body.weights.T, strict=True):
        np.add.at(weights, (rows, groups.members[joints]), shares)
    return weights


# A cap runs straight from its rim towards the middle of the hole for this share of the way, and only then into the
# neighbour, by so many radii of the hole. A cone from the rim on comes out of the skin where that is hollow: by 2.8 mm
# at the throat of our bust. Flat caps leave 4 % of MakeHuman's body hollow, where three parts meet; these a thousandth.
COLLAR, REACH = 0.2, 1.0


class Cut(NamedTuple):
    """A patch of the skin that belongs to a group of bones."""

    group: int
    vertices: np.ndarray  # vertices of the body in the patch, (k,) int64
    triangles: np.ndarray  # triangles between them, indices into `vertices`, (m, 3) int32
    rim: np.ndarray  # vertices on open edges of the body itself, (k,) bool


class Edges(NamedTuple):
    """The edge graph of a skin. Coincident vertices count as one: skins are split along the seams of their texture."""

    places: np.ndarray  # node of every vertex, (n,) int64
    ends: np.ndarray  # nodes at the ends of the edges, (e, 2) int64
    lengths: np.ndarray  # of the edges [m], (e,) float64


def cut_skin(body: Body, groups: Groups, overlap: float) -> list[Cut]:
    """Return the patches of all groups that have skin, which overlap [m] along the skin; warn of holes to be capped.

    Two bones share the skin where both have weight 1/2. Skin shared by more than two belongs to the first of them, so
    that no skin is omitted.
    """
    owners = group_weights(body, groups).argmax(axis=1)
    edges = edges_along(body.mesh)
    open_places = np.zeros(edges.places.max() + 1, bool)
    found, _ = openings(body.mesh)
    for hole in found:
        open_places[edges.places[hole.loop]] = True
    if found:
        warn(f"body: capped {describe(found)}", stacklevel=2)
    rim = open_places[edges.places]
    return [patch(body.mesh, edges, rim, group, owners == group, overlap) for group in np.unique(owners).tolist()]


def patch(mesh: Mesh, edges: Edges, rim: np.ndarray, group: int, own: np.ndarray, overlap: float) -> Cut:
    """Return the patch of the vertices that are its own, (n,) bool, and of all within a distance [m] from those."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    size = edges.places.max() + 1
    graph = coo_array((edges.lengths, (edges.ends[:, 0], edges.ends[:, 1])), shape=(size, size)).tocsr()
    distances = dijkstra(graph, directed=False, indices=np.unique(edges.places[own]), limit=overlap, min_only=True)
    near = np.isfinite(distances)[edges.places]
    vertices, triangles = np.unique(mesh.triangles[near[mesh.triangles].any(axis=1)], return_inverse=True)
    return Cut(group, vertices, triangles.reshape(-1, 3).astype(np.int32), rim[vertices])


def edges_along(mesh: Mesh) -> Edges:
    points, places = np.unique(mesh.points, axis=0, return_inverse=True)
    places = places.reshape(-1)
    ends = np.sort(places[mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)], axis=1)
    ends = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    return Edges(places, ends, np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1))


def closed(points: np.ndarray, triangles: np.ndarray, rim: np.ndarray) -> Mesh:
    """Return a patch closed by caps across its holes, static; at the cuts, which are not on its rim, by hats.

    A hat is a flat collar across a limb, and a cone inside the adjacent part.
    """
    mesh = Mesh(points, triangles, np.zeros_like(points))
    found = openings(mesh)[0]
    cut = [not rim[hole.loop].any() for hole in found]
    tall = [raised(mesh, hole) if here else hole for here, hole in zip(cut, found, strict=True)]
    for number in np.flatnonzero(cut):
        hole = found[number]
        here = hole.loop
        ahead = np.roll(hole.loop, -1)
        ring = mesh.points[here] + COLLAR * (hole.centre - mesh.points[here])
        inner = len(mesh.points) + np.arange(len(here))
        next_inner = np.roll(inner, -1)
        collar = np.concatenate([np.stack([ahead, here, inner], 1), np.stack([ahead, inner, next_inner], 1)])
        points = np.concatenate([mesh.points, ring])
        mesh = Mesh(points, np.concatenate([mesh.triangles, collar.astype(np.int32)]), np.zeros_like(points))
        tall[number] = tall[number]._replace(loop=inner)
    return capped(mesh, tall)


def raised(mesh: Mesh, hole: Hole) -> Hole:
    """Return a hole with its middle moved outwards, away from the skin that ends there."""
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
    """Return the parts of a body in a pose, baked as `bake` does; without a pose, at rest and static. Pure.

    smallest  minimum size of a part of the skin [m]; bones with less move with their parents

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
            local = (points[cut.vertices] - place[:, 3]) @ place[:, :3]
            patch_bytes = (np.round(local * STEPS) / STEPS + 0.0).tobytes(), cut.triangles.tobytes(), cut.rim.tobytes()
            part, share = bake_once(*patch_bytes, voxel, half_width)
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
    """Return the frames of bones, or of the world for -1, [R | p] [m] and its rate, (G, 3, 4) each; R is since rest."""
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


@lru_cache(maxsize=REMEMBERED)
def bake_once(points: bytes, triangles: bytes, rim: bytes, voxel: float, half_width: float) -> tuple[LevelSet, float]:
    """Return the level set of an open patch, closed by caps, without velocities, and the lost share of its area."""
    skin_part = np.frombuffer(points).reshape(-1, 3), np.frombuffer(triangles, np.int32).reshape(-1, 3)
    mesh = closed(*skin_part, np.frombuffer(rim, bool))
    surface = Surface(mesh.points[mesh.triangles], np.zeros((len(mesh.triangles), 3, 3)))
    wide_triangles(surface.corners)
    found, lost = bake_surface(surface, lattice_around(surface.corners, voxel, half_width), half_width)
    return replace(found, velocity=np.empty((0, *found.velocity.shape[1:]), np.float32)), lost
