"""Meshes, bodies and motion of glTF files: skins and morph targets."""

import warnings
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at
from hairpipe.formats.gltf import Document
from hairpipe.formats.gltf_nodes import Animation
from hairpipe.formats.polygons import Polygons, join_polygons, warn_of_unused
from hairpipe.formats.rigging import NOBODY, JointMotion, Key, Part, join_parts, jointed, rigid, unique_names
from hairpipe.values import Body, Mesh, Skeleton

KNOWN = ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0")
MOST_FRAMES = 1_000_000
"""Largest number of frames of an animation."""
TRIANGLES = 4
"""Mode of primitives: others are strips, fans, lines and points."""


class Piece(NamedTuple):
    """A mesh of a node, with welded vertices: formats for graphics cards have several where normals differ.

    points   at rest, in the space of the mesh [m], (n, 3) float64
    targets  displacements of the morph targets [m], (t, n, 3) float64
    skin     index of the skin; None without one, or without joints of vertices
    joints   nodes that move a vertex, (n, k) int64; weights  (n, k) float64, rows of sum 1
    maps     painted vertex values by name, (n,) float64
    """

    node: int
    points: np.ndarray
    targets: np.ndarray
    triangles: np.ndarray
    uv: np.ndarray | None
    skin: int | None
    joints: np.ndarray
    weights: np.ndarray
    maps: dict[str, np.ndarray]


class SkinnedPieces:
    """Samples of the meshes of a file, one a frame of the shot, see `animated_meshes.Samples`.

    Between keys rotations turn along arcs, which a cubic between sparse keys would not follow.
    """

    def __init__(self, path: Path, group: str | None, clip: str | None, fps: float, moves: bool = True) -> None:
        self.path, self.rate = path, fps
        self.document = Document(path)
        self.files = self.document.files()
        self.animation = Animation(self.document, clip, moves)
        self.pieces = [piece for node in self.animation.order for piece in self._pieces(node, group)]
        if not self.pieces:
            right = "a node with a mesh of triangles"
            raise BadInput(f"no mesh{'' if group is None else f' named {group}'}", where=path, right=right)
        self.skins = {p.skin: self._bind(p.skin) for p in self.pieces if p.skin is not None}
        first, last = self.animation.span or (0.0, 0.0)
        if not 0.0 <= (last - first) * fps <= MOST_FRAMES:
            right = f"at most {MOST_FRAMES:,} frames"
            raise BadInput(f"the animation takes {last - first:g} s", where=path, right=right)
        whole = np.arange(np.ceil(first * fps), np.floor(last * fps) + 1.0)
        codes = np.sort([first * fps, *whole, last * fps])
        self.codes = codes[np.insert(np.diff(codes) > 1e-6, 0, True)]
        self.own = [False] * len(self.pieces)

    def shape(self, sample: int) -> Polygons:
        pairs = zip(self.sample(sample), self.pieces, strict=True)
        meshes = [Mesh(points, piece.triangles, uv=piece.uv) for (points, _), piece in pairs]
        return join_polygons([Polygons(mesh, np.arange(len(mesh.triangles))) for mesh in meshes])

    def sample(self, sample: int) -> list[Points]:
        return [(points, None) for points in self.at(float(self.codes[sample] / self.rate))]

    def at(self, time: float | None) -> list[np.ndarray]:
        """Return the points of the meshes at a time [s], or at rest for None [m], (n, 3) each."""
        world = self.animation.transforms(time)
        found = [self._deformed(piece, world, time) for piece in self.pieces]
        if not all(np.isfinite(points).all() for points in found):
            raise BadInput("points are not finite", where=self.path, right="smaller scales, weights and translations")
        return found

    def _deformed(self, piece: Piece, world: np.ndarray, time: float | None) -> np.ndarray:
        points = piece.points
        if len(piece.targets):
            weights = self.animation.weights(piece.node, len(piece.targets), time)
            points = points + np.einsum("t,tnx->nx", weights, piece.targets)
        if piece.skin is None:
            return points @ world[piece.node, :3, :3].T + world[piece.node, :3, 3]
        matrices = world[:, :3].copy()
        nodes, bind = self.skins[piece.skin]
        matrices[nodes] = (world[nodes] @ bind)[:, :3]
        moved = np.zeros_like(points)
        for k in range(piece.joints.shape[1]):
            m = matrices[piece.joints[:, k]]
            moved += piece.weights[:, k, None] * (np.einsum("nij,nj->ni", m[:, :, :3], points) + m[:, :, 3])
        return moved

    def _bind(self, skin: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the joints of a skin, nodes (j,), and their inverse bind matrices, (j, 4, 4)."""
        given = self.document.get("skins")[skin]
        nodes = np.array(given["joints"], np.int64)
        where = f"{self.path}, skin {skin}"
        if lost := set(given["joints"]).difference(self.animation.order):
            raise BadInput(f"the joint {min(lost)} is not in the scene", where=where, right="a node of the scene")
        if "inverseBindMatrices" not in given:
            return nodes, np.tile(np.eye(4), (len(nodes), 1, 1))
        found = self.document.numbers(given["inverseBindMatrices"], 16).reshape(-1, 4, 4)
        if len(found) < len(nodes):
            raise BadInput(f"there are {len(found)} inverse bind matrices", where=where, right=f"{len(nodes)}")
        return nodes, np.swapaxes(found, 1, 2)[: len(nodes)]

    def _pieces(self, node: int, group: str | None) -> list[Piece]:
        given = self.document.get("nodes")[node]
        if "mesh" not in given or not self._fits(node, group):
            return []
        mesh = self.document.get("meshes")[given["mesh"]]
        name = f"{self.path}, mesh {mesh.get('name', given['mesh'])}"
        parts = [p for p in mesh["primitives"] if p.get("mode", TRIANGLES) == TRIANGLES]
        if len(parts) < len(mesh["primitives"]):
            warnings.warn(f"{name} has lines, points, strips or fans, which are not read", stacklevel=2)
        counts = sorted({len(p.get("targets", ())) for p in parts})
        if len(counts) > 1:
            right = f"{counts[-1]} for each, or none"
            raise BadInput(f"a primitive has {counts[0]} morph targets", where=name, right=right)
        return [weld(self._primitive(part, node, name)) for part in parts]

    def _fits(self, node: int, group: str | None) -> bool:
        """Return whether the name of a node, or of one above it, is that of a group or fits its pattern."""
        while node >= 0:
            name = str(self.document.get("nodes")[node].get("name", ""))
            if group is None or name == group or fnmatchcase(name, group):
                return True
            node = self.animation.parents[node]
        return False

    def _primitive(self, part: dict[str, Any], node: int, where: str) -> Piece:
        given = part.get("attributes", {})
        if "POSITION" not in given:
            raise BadInput("a primitive has no positions", where=where, right="the attribute POSITION")
        points = self.document.numbers(given["POSITION"], 3).astype(float)
        n = len(points)
        if not n:
            raise BadInput("a primitive has no positions", where=where, right="3 or more")

        def numbers(index: int, columns: int) -> np.ndarray:
            found = self.document.numbers(index, columns)
            if len(found) != n:
                at = f"{self.path}, accessor {index}"
                raise BadInput(f"{len(found)} elements for {n} vertices", where=at, right="as many as positions")
            return found

        corners = self.document.numbers(part["indices"], 1).astype(np.int64) if "indices" in part else np.arange(n)
        if len(corners) % 3 or (len(corners) and not 0 <= corners.min() <= corners.max() < n):
            raise BadInput("indices are not those of triangles", where=where, right=f"triples of 0 to {n - 1}")
        targets = [numbers(t["POSITION"], 3) if "POSITION" in t else np.zeros((n, 3)) for t in part.get("targets", ())]
        sets = [k for k in range(16) if f"JOINTS_{k}" in given and f"WEIGHTS_{k}" in given]
        indices, shares = ([numbers(given[f"{name}_{k}"], 4) for k in sets] for name in ("JOINTS", "WEIGHTS"))
        skin = self.document.get("nodes")[node].get("skin") if sets else None
        joints, weights = self._influences(indices, shares, skin, node, n, where)
        triangles = corners.reshape(-1, 3)
        uv = numbers(given["TEXCOORD_0"], 2)[triangles] * (1, -1) + (0, 1) if "TEXCOORD_0" in given else None
        scalars = self.document.get("accessors")
        painted = [k for k, index in given.items() if k.startswith("_") and scalars[index].get("type") == "SCALAR"]
        maps = {name[1:].lower(): numbers(given[name], 1).astype(float).clip(0.0, 1.0) for name in painted}
        known = [name for name in given if name.startswith(("JOINTS_", "WEIGHTS_"))]
        warn_of_unused(where, given.keys() - {*KNOWN, *painted, *known})
        stacked = np.array(targets, float).reshape(-1, n, 3)
        texture = None if uv is None else uv.astype(np.float32)
        return Piece(node, points, stacked, triangles, texture, skin, joints, weights, maps)

    def _influences(
        self, indices: list[np.ndarray], shares: list[np.ndarray], skin: int | None, node: int, n: int, where: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes that move vertices, (n, k), and their weights, (n, k), from those of each set of four."""
        if skin is None:
            return np.full((n, 1), node), np.ones((n, 1))
        nodes = np.array(self.document.get("skins")[skin]["joints"], np.int64)
        joints = np.concatenate(indices, axis=1).astype(int)
        weights = np.concatenate(shares, axis=1).astype(float)
        if joints.min() < 0 or joints.max() >= len(nodes) or weights.min() < 0.0:
            right = f"joints 0 to {len(nodes) - 1}, weights of 0 or more"
            raise BadInput("a vertex has an invalid joint or weight", where=where, right=right)
        bare = weights.sum(axis=1) == 0.0
        weights[bare, 0] = 1.0
        return nodes[joints], weights / weights.sum(axis=1, keepdims=True)


def weld(piece: Piece) -> Piece:
    """Return a mesh whose equal vertices, in position, morph targets, skin and maps, are one; pure."""
    n = len(piece.points)
    columns = [piece.points, piece.targets.swapaxes(0, 1).reshape(n, -1), piece.joints, piece.weights]
    columns += [values[:, None] for values in piece.maps.values()]
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1) + 0.0)
    _, first, place = np.unique(
        rows.view([("", rows.dtype)] * rows.shape[1])[:, 0], return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    kept = first[order]
    triangles = np.argsort(order)[place.reshape(-1)][piece.triangles]
    real = (triangles != triangles[:, (1, 2, 0)]).all(axis=1)
    return piece._replace(
        points=piece.points[kept],
        targets=piece.targets[:, kept],
        triangles=np.ascontiguousarray(triangles[real], np.int32),
        uv=None if piece.uv is None else piece.uv[real],
        joints=piece.joints[kept],
        weights=piece.weights[kept],
        maps={name: values[kept] for name, values in piece.maps.items()},
    )


def read_moving(path: Path, group: str | None, clip: str | None, instant: Instant) -> Polygons:
    """Read the meshes of a clip at an instant."""
    return read_at(recall(SkinnedPieces, path, group, clip, instant.fps), instant)


ALIKE = 1e-5
"""Largest difference of motions of a joint from the bound mesh to rest, relative or [m]: positions are float32."""


class Joints(NamedTuple):
    """Nodes that move the meshes of a file, a parent before its children, (J,), and their transforms [m], (J, 4, 4)."""

    nodes: list[int]
    world: np.ndarray
    skeleton: Skeleton


def find_joints(pieces: SkinnedPieces) -> Joints:
    """Find the nodes of skins, and of meshes without one; BadInput where one has no inverse at rest."""
    animation = pieces.animation
    used = {int(node) for piece in pieces.pieces for node in np.unique(piece.joints)}
    nodes = [node for node in animation.order if node in used]
    given = [str(animation.nodes[node].get("name") or f"node{node}") for node in nodes]
    names = [n if given.count(n) == 1 else f"{n}#{node}" for n, node in zip(given, nodes, strict=True)]
    above = animation.parents.tolist()
    parents = list[int]()
    for node in nodes:
        parent = above[node]
        while parent >= 0 and parent not in used:
            parent = above[parent]
        parents.append(nodes.index(parent) if parent >= 0 else -1)
    world = animation.transforms(None)[nodes]
    volumes = np.abs(np.linalg.det(world[:, :3, :3]))
    if volumes.min() < 1e-30:
        where = f"{pieces.path}, joint {names[int(np.argmin(volumes))]}"
        raise BadInput("the transform at rest cannot be inverted", where=where, right="a scale that is not 0")
    return Joints(nodes, world, jointed(names, np.array(parents, np.int32), rigid(world)))


def read_body(path: Path, group: str | None = None) -> Body:
    """Read the meshes of a file at rest as one body, with the joints of their skins; without skins it has no joints.

    group  name of a node, or a pattern of names, to read with all below; None for all

    Raises BadInput where the file cannot be used; the message names the mesh or the accessor.
    """
    pieces = SkinnedPieces(path, group, None, 24.0, moves=False)
    joints = find_joints(pieces) if pieces.skins else None
    places = np.zeros(len(pieces.animation.nodes), np.int32)
    if joints:
        places[joints.nodes] = np.arange(len(joints.nodes))
    binds = bind_pieces(pieces)
    names = name_weights(pieces)
    parts = list[Part]()
    for points, piece, (matrix, _) in zip(pieces.at(None), pieces.pieces, binds, strict=True):
        mesh = Mesh(points, piece.triangles, uv=piece.uv)
        k = piece.joints.shape[1] if joints else 0
        base = piece.points @ matrix[:3, :3].T + matrix[:3, 3]
        rows = [np.flatnonzero((target != 0.0).any(axis=1)) for target in piece.targets]
        targets = zip(names[piece.node], piece.targets, rows, strict=True)
        keys = [Key(name, 1.0, row, target[row] @ matrix[:3, :3].T) for name, target, row in targets]
        parts.append(Part(mesh, piece.maps, places[piece.joints[:, :k]], piece.weights[:, :k], base, keys))
    skeleton = joints.skeleton if joints else NOBODY
    turns = join_turns(joints, [turns for _, turns in binds], f"{path}") if joints else np.zeros((0, 4, 4))
    return join_parts(parts, skeleton, turns, weights_of(pieces, names, None))


def bind_pieces(pieces: SkinnedPieces) -> list[tuple[np.ndarray, dict[int, np.ndarray]]]:
    """Return the matrix of every mesh to its place in the world, (4, 4), and motions of its nodes from there to rest.

    The place is the one at rest, where nodes agree about it. A mesh with a node of another mesh has the place from
    which that node moves both alike.
    """
    world = pieces.animation.transforms(None)
    moved = list[dict[int, np.ndarray]]()
    for piece in pieces.pieces:
        own = (np.array([piece.node]), np.eye(4)[None])
        nodes, unbind = own if piece.skin is None else pieces.skins[piece.skin]
        used = np.isin(nodes, piece.joints)
        moved.append(dict(zip(nodes[used].tolist(), world[nodes[used]] @ unbind[used], strict=True)))
    found = dict[int, tuple[np.ndarray, dict[int, np.ndarray]]]()
    turns = dict[int, np.ndarray]()
    while len(found) < len(moved):
        waiting = [n for n in range(len(moved)) if n not in found]
        number = next((n for n in waiting if not turns.keys().isdisjoint(moved[n])), waiting[0])
        regular = {node: motion for node, motion in moved[number].items() if abs(np.linalg.det(motion[:3, :3])) > 1e-30}
        first = next(iter(moved[number]))
        place = next(
            (np.linalg.inv(turns[node]) @ motion for node, motion in regular.items() if node in turns),
            regular.get(first, np.eye(4)),
        )
        unplace = np.linalg.inv(place)
        found[number] = place, {node: motion @ unplace for node, motion in moved[number].items()}
        turns = {node: found[number][1][node] for node in regular} | turns
    return [found[n] for n in range(len(moved))]


def join_turns(joints: Joints, binds: list[dict[int, np.ndarray]], where: str) -> np.ndarray:
    """Return the motion of each joint from the bound mesh to rest, (J, 4, 4); warns where meshes disagree about one."""
    turns = np.tile(np.eye(4), (len(joints.nodes), 1, 1))
    for place, node in enumerate(joints.nodes):
        found = [bind[node] for bind in binds if node in bind]
        turns[place] = found[0]
        if any(np.abs(other - found[0]).max() > ALIKE for other in found):
            message = f"{where}: skins bind the joint {joints.skeleton.names[place]} in several ways"
            warnings.warn(f"{message}: poses follow the first (load_mesh_cache reads all points)", stacklevel=2)
    return turns


def name_weights(pieces: SkinnedPieces) -> dict[int, list[str]]:
    """Return the names of the morph targets of every node with a mesh.

    Those of a name have their number, in one node, or their node: smile#2.
    """
    given = dict[int, list[str]]()
    for piece in pieces.pieces:
        mesh = pieces.document.get("meshes")[pieces.animation.nodes[piece.node]["mesh"]]
        extras = mesh.get("extras")
        named = extras.get("targetNames") if isinstance(extras, dict) else None
        named = named if isinstance(named, list) else []
        count = len(piece.targets)
        names = [str(named[k]) if k < len(named) else f"target{k}" for k in range(count)]
        given[piece.node] = unique_names(names, range(count))
    owners = [node for node, names in given.items() for _ in names]
    unique = iter(unique_names([name for names in given.values() for name in names], owners))
    return {node: [next(unique) for _ in names] for node, names in given.items()}


def weights_of(pieces: SkinnedPieces, named: dict[int, list[str]], time: float | None) -> dict[str, float]:
    """Return the weights of the morph targets, named by node, at a time [s], or at rest, by name."""
    return {
        name: float(weight)
        for node, names in named.items()
        for name, weight in zip(names, pieces.animation.weights(node, len(names), time), strict=True)
    }


def read_joints(path: Path, group: str | None, clip: str | None, fps: float) -> JointMotion:
    """Read the joints and weights of a clip, with a sample at each frame of the shot."""
    pieces = SkinnedPieces(path, group, clip, fps)
    joints = find_joints(pieces)
    unbind = np.linalg.inv(joints.world) @ joints.skeleton.rest
    moved = [pieces.animation.transforms(float(code / fps))[joints.nodes] @ unbind for code in pieces.codes]
    named = name_weights(pieces)
    weights = np.array([[*weights_of(pieces, named, float(code / fps)).values()] for code in pieces.codes])
    shapes = tuple(weights_of(pieces, named, None))
    return JointMotion(joints.skeleton, np.array(moved), pieces.codes, fps, float(pieces.codes[0]), shapes, weights)
