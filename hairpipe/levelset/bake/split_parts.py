"""Cutting of a body's skin into parts: closed patches that overlap their neighbours a little."""

from typing import NamedTuple
from warnings import warn

import numpy as np

from hairpipe.body.groups import Groups, group_weights
from hairpipe.data import Body, Mesh
from hairpipe.levelset.bake.closed_surface import openings
from hairpipe.levelset.bake.holes import Hole, capped, describe

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
