"""Bodies at rest of glTF files, and the poses of their joints."""

import warnings
from pathlib import Path

import numpy as np

from hairpipe.data import Body, Mesh, Skeleton
from hairpipe.errors import BadInput
from hairpipe.io.gltf.skinned_pieces import SkinnedPieces
from hairpipe.io.mesh_cache.joint_motion import JointMotion
from hairpipe.io.polygons import merge_meshes
from hairpipe.io.rigging import find_tips, merge_maps, rigid, stack_influences


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


def read_joints(path: Path, group: str | None, clip: str | None, fps: float) -> JointMotion:
    """Read the joints of a clip, with a sample at each frame of the shot; warns of morph targets."""
    pieces = SkinnedPieces(path, group, clip, fps)
    if any(len(piece.targets) for piece in pieces.pieces):
        warnings.warn(f"{path} has morph targets, which are not in a pose: load_mesh_cache reads them", stacklevel=2)
    joints = Joints(pieces)
    unbind = np.linalg.inv(joints.world) @ joints.rest
    moved = [pieces.animation.transforms(float(code / fps))[joints.nodes] @ unbind for code in pieces.codes]
    return JointMotion(joints.skeleton(), np.array(moved), pieces.codes, fps, 0.0)
