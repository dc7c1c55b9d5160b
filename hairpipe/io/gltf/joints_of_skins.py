"""Bodies at rest of glTF files, and the poses of their joints."""

import warnings
from pathlib import Path

import numpy as np

from hairpipe.data import Body, Mesh, Pose, Skeleton
from hairpipe.errors import BadInput
from hairpipe.io.gltf.skinned_pieces import SkinnedPieces
from hairpipe.io.mesh_cache.moving import Instant, Points, Shape, read_at
from hairpipe.io.polygons import merge_meshes
from hairpipe.io.rigging import find_tips, merge_maps, rigid, stack_influences

ALIKE = 1e-6
"""Largest difference of joints at rest [m]."""


class Joints:
    """Nodes that move the meshes of a file, as samples of the columns of their transforms from rest.

    nodes    a parent before its children, (J,)
    names    of the nodes, unique
    parents  index of the next joint above, -1 at a root, (J,) int32
    rest     joint-to-world at rest, rotations and translations [m], (J, 4, 4)

    See `hairpipe.io.mesh_cache.moving.Source`: column k of joint j is point 4 j + k.
    """

    def __init__(self, pieces: SkinnedPieces) -> None:
        self.pieces, self.codes, self.rate, self.own = pieces, pieces.codes, pieces.rate, [False]
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

    def shape(self, sample: int) -> Shape:
        """Return the columns at a sample as points without triangles."""
        points, _ = self.sample(sample)[0]
        return Shape(Mesh(points, np.zeros((0, 3), np.int32)), np.zeros(0, np.int64))

    def sample(self, sample: int) -> list[Points]:
        """Return the columns of the transforms at a sample: those that move the skin as the file does."""
        world = self.pieces.animation.transforms(float(self.codes[sample] / self.rate))[self.nodes]
        moved = world @ np.linalg.inv(self.world) @ self.rest
        return [(moved[:, :3].swapaxes(1, 2).reshape(-1, 3), None)]


def read_body(path: Path, group: str | None = None) -> Body:
    """Read the meshes of a file at rest as one body, with the joints of their skins; without skins it has no joints.

    group  name of a node, or a pattern of names, to read with all below; None for all

    Raises BadInput where the file cannot be used; the message names the mesh or the accessor.
    """
    pieces = SkinnedPieces(path, group, None, 24.0, moves=False)
    points = pieces.at(None)
    mesh = merge_meshes([Mesh(p, piece.triangles, uv=piece.uv) for p, piece in zip(points, pieces.pieces, strict=True)])
    maps = merge_maps([piece.maps for piece in pieces.pieces], [len(piece.points) for piece in pieces.pieces])
    if not pieces.skins:
        n = len(mesh.points)
        nobody = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
        return Body(mesh, nobody, np.zeros((n, 0), np.int32), np.zeros((n, 0)), maps)
    joints = Joints(pieces)
    place = np.zeros(len(pieces.animation.nodes), np.int32)
    place[joints.nodes] = np.arange(len(joints.nodes))
    influences = stack_influences([place[piece.joints] for piece in pieces.pieces])
    weights = stack_influences([piece.weights for piece in pieces.pieces])
    return Body(mesh, joints.skeleton(), influences, weights, maps)


def read_pose(path: Path, skeleton: Skeleton, clip: str | None, instant: Instant) -> Pose:
    """Read the pose of a skeleton of the same file, or of another with joints of the same names, at an instant.

    Raises BadInput where the file has no such joint, or another rest pose. Warns of morph targets.
    """
    pieces = SkinnedPieces(path, None, clip, instant.fps)
    joints = Joints(pieces)
    if any(len(piece.targets) for piece in pieces.pieces):
        warnings.warn(f"{path} has morph targets, which are not in a pose: load_mesh_cache reads them", stacklevel=2)
    missing = [name for name in skeleton.names if name not in joints.names]
    if missing:
        right = f"the joints of the body, of {', '.join(joints.names[:8])}"
        raise BadInput(f"there is no joint {missing[0]!r}", where=path, right=right)
    found, _ = read_at(joints, instant)
    order = [joints.names.index(name) for name in skeleton.names]
    if np.abs(joints.rest[order] - skeleton.rest).max() > ALIKE:
        right = "the body of this file, read without `unit` and `up`"
        raise BadInput("the joints at rest are not those of the body", where=path, right=right)
    transforms, rates = (np.zeros((len(order), 4, 4)) for _ in range(2))
    transforms[:, 3, 3] = 1.0
    for result, columns in ((transforms, found.points), (rates, found.rates)):
        result[:, :3] = columns.reshape(-1, 4, 3)[order].swapaxes(1, 2)
    return Pose(transforms, rates)
