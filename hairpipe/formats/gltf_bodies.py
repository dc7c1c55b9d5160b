"""Bodies at rest of glTF files, and the poses of their joints."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.gltf_meshes import Piece, SkinnedPieces
from hairpipe.formats.joint_motion import JointMotion
from hairpipe.formats.polygons import merge_meshes
from hairpipe.formats.rigging import Key, find_tips, join_shapes, merge_maps, rigid, stack_influences, unique_names
from hairpipe.values import Body, Bound, Mesh, Skeleton

ROUNDED = 1e-9
"""Largest difference of bound mesh and rest that rounding explains."""
ALIKE = 1e-5
"""Largest difference of motions of a joint from the bound mesh to rest, relative or [m]: positions are float32."""


class Joints:
    """Nodes that move the meshes of a file.

    nodes    a parent before its children, (J,)
    names    of the nodes, unique
    parents  index of the next joint above, -1 at a root, (J,) int32
    world    joint-to-world at rest [m], (J, 4, 4)
    rest     the same without scale
    """

    def __init__(self, pieces: SkinnedPieces) -> None:
        self.pieces = pieces
        animation = pieces.animation
        used = {int(node) for piece in pieces.pieces for node in np.unique(piece.joints)}
        self.nodes = [node for node in animation.order if node in used]
        given = [str(animation.nodes[node].get("name") or f"node{node}") for node in self.nodes]
        self.names = tuple(
            name if given.count(name) == 1 else f"{name}#{node}" for name, node in zip(given, self.nodes, strict=True)
        )
        self.parents = np.array([self._parent(node) for node in self.nodes], np.int32)
        self.world = animation.transforms(None)[self.nodes]
        where = f"{pieces.path}, joint {self.names[int(np.argmin(np.abs(np.linalg.det(self.world[:, :3, :3]))))]}"
        if np.abs(np.linalg.det(self.world[:, :3, :3])).min() < 1e-30:
            raise BadInput("the transform at rest cannot be inverted", where=where, right="a scale that is not 0")
        self.rest = rigid(self.world)

    def _parent(self, node: int) -> int:
        parents = self.pieces.animation.parents.tolist()
        above = parents[node]
        while above >= 0 and above not in self.nodes:
            above = parents[above]
        return self.nodes.index(above) if above >= 0 else -1

    def skeleton(self) -> Skeleton:
        """Return the joints at rest."""
        return Skeleton(self.names, self.parents, self.rest, find_tips(self.parents, self.rest[:, :3, 3]))


def read_body(path: Path, group: str | None = None) -> Body:
    """Read the meshes of a file at rest as one body, with the joints of their skins; without skins it has no joints.

    group  name of a node, or a pattern of names, to read with all below; None for all

    Raises BadInput where the file cannot be used; the message names the mesh or the accessor.
    """
    pieces = SkinnedPieces(path, group, None, 24.0, moves=False)
    points = pieces.at(None)
    mesh = merge_meshes([Mesh(p, piece.triangles, uv=piece.uv) for p, piece in zip(points, pieces.pieces, strict=True)])
    counts = [len(piece.points) for piece in pieces.pieces]
    maps = merge_maps([piece.maps for piece in pieces.pieces], counts)
    binds = bind_pieces(pieces)
    names = name_weights(pieces)
    rest = weights_of(pieces, names, None)
    keys = [keys_of(piece, names[piece.node], matrix) for piece, (matrix, _) in zip(pieces.pieces, binds, strict=True)]
    shapes = join_shapes(keys, counts, rest)
    bases = [piece.points @ m[:3, :3].T + m[:3, 3] for piece, (m, _) in zip(pieces.pieces, binds, strict=True)]
    bound = Bound(np.concatenate(bases), np.zeros((0, 4, 4)))
    if not pieces.skins:
        n = len(mesh.points)
        nobody = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
        bound = bound if any(rest.values()) else None
        return Body(mesh, nobody, np.zeros((n, 0), np.int32), np.zeros((n, 0)), maps, shapes=shapes, bound=bound)
    joints = Joints(pieces)
    place = np.zeros(len(pieces.animation.nodes), np.int32)
    place[joints.nodes] = np.arange(len(joints.nodes))
    bound = replace(bound, turns=join_turns(joints, [turns for _, turns in binds], f"{path}"))
    if np.abs(bound.turns - np.eye(4)).max() < ROUNDED and not any(rest.values()):
        bound = None
    influences = stack_influences([place[piece.joints] for piece in pieces.pieces])
    weights = stack_influences([piece.weights for piece in pieces.pieces])
    return Body(mesh, joints.skeleton(), influences, weights, maps, shapes=shapes, bound=bound)


def bind_pieces(pieces: SkinnedPieces) -> list[tuple[np.ndarray, dict[int, np.ndarray]]]:
    """Return the matrix of every mesh to its place in the world, (4, 4), and motions of its nodes from there to rest.

    The place is the one at rest, where nodes agree about it. A mesh with a node of another mesh has the place from
    which that node moves both alike.
    """
    moved = [motions_of(pieces, piece) for piece in pieces.pieces]
    found = dict[int, tuple[np.ndarray, dict[int, np.ndarray]]]()
    turns = dict[int, np.ndarray]()
    while len(found) < len(moved):
        waiting = [n for n in range(len(moved)) if n not in found]
        number = next((n for n in waiting if not turns.keys().isdisjoint(moved[n])), waiting[0])
        regular = {node: motion for node, motion in moved[number].items() if is_regular(motion)}
        first = next(iter(moved[number]))
        place = next(
            (np.linalg.inv(turns[node]) @ motion for node, motion in regular.items() if node in turns),
            regular.get(first, np.eye(4)),
        )
        unplace = np.linalg.inv(place)
        found[number] = place, {node: motion @ unplace for node, motion in moved[number].items()}
        turns = {node: found[number][1][node] for node in regular} | turns
    return [found[n] for n in range(len(moved))]


def motions_of(pieces: SkinnedPieces, piece: Piece) -> dict[int, np.ndarray]:
    """Return the matrices (4, 4) by which the nodes of a mesh move its points to rest."""
    world = pieces.animation.transforms(None)
    nodes, unbind = pieces.skins[piece.skin] if piece.skin is not None else (np.array([piece.node]), np.eye(4)[None])
    used = np.isin(nodes, piece.joints)
    return dict(zip(nodes[used].tolist(), world[nodes[used]] @ unbind[used], strict=True))


def is_regular(matrix: np.ndarray) -> bool:
    """Return whether an affine matrix (4, 4) has an inverse."""
    return abs(np.linalg.det(matrix[:3, :3])) > 1e-30


def join_turns(joints: Joints, binds: list[dict[int, np.ndarray]], where: str) -> np.ndarray:
    """Return the motion of each joint from the bound mesh to rest, (J, 4, 4); warns where meshes disagree about one."""
    turns = np.tile(np.eye(4), (len(joints.nodes), 1, 1))
    for place, node in enumerate(joints.nodes):
        found = [bind[node] for bind in binds if node in bind]
        turns[place] = found[0]
        if any(np.abs(other - found[0]).max() > ALIKE for other in found):
            message = f"{where}: skins bind the joint {joints.names[place]} in several ways"
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
    """Return the weights of the morph targets at a time [s], or at rest, by name.

    named  names of the morph targets of every node
    """
    return {
        name: float(weight)
        for node, names in named.items()
        for name, weight in zip(names, pieces.animation.weights(node, len(names), time), strict=True)
    }


def keys_of(piece: Piece, names: list[str], matrix: np.ndarray) -> list[Key]:
    """Return the morph targets of a mesh as keys, moved by a matrix (4, 4)."""
    rows = [np.flatnonzero((target != 0.0).any(axis=1)) for target in piece.targets]
    moved = [target[row] @ matrix[:3, :3].T for target, row in zip(piece.targets, rows, strict=True)]
    return [Key(name, 1.0, row, offsets) for name, row, offsets in zip(names, rows, moved, strict=True)]


def read_joints(path: Path, group: str | None, clip: str | None, fps: float) -> JointMotion:
    """Read the joints and weights of a clip, with a sample at each frame of the shot."""
    pieces = SkinnedPieces(path, group, clip, fps)
    joints = Joints(pieces)
    unbind = np.linalg.inv(joints.world) @ joints.rest
    moved = [pieces.animation.transforms(float(code / fps))[joints.nodes] @ unbind for code in pieces.codes]
    named = name_weights(pieces)
    weights = np.array([[*weights_of(pieces, named, float(code / fps)).values()] for code in pieces.codes])
    shapes = tuple(weights_of(pieces, named, None))
    return JointMotion(joints.skeleton(), np.array(moved), pieces.codes, fps, float(pieces.codes[0]), shapes, weights)
