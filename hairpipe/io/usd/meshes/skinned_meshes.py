"""Body of a stage: its meshes as one, and their skeletons."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdGeom, UsdSkel

from hairpipe.data import Body, Bound, DualQuaternions
from hairpipe.io.polygons import merge_meshes
from hairpipe.io.rigging import Key, join_shapes, merge_maps, stack_influences
from hairpipe.io.usd.meshes.blend_shapes import Names, name_weights, read_keys
from hairpipe.io.usd.meshes.mesh import Painted, read_mesh, warn_of_scheme
from hairpipe.io.usd.meshes.skeleton import (
    REST,
    Binding,
    Rig,
    find_bindings,
    has_blend_shapes,
    join_rigs,
    read_influences,
    read_rig,
    skin_at_rest,
)
from hairpipe.io.usd.stage import columns, go_to, move, numbers, open_whole, place, read_time, shown, usd_faults
from hairpipe.plain_file import Absent


@dataclass(frozen=True)
class Piece:
    """One mesh of the body, n vertices, each following k joints of the whole skeleton.

    joints   (n, k) int32
    weights  (n, k) float64
    bound    points before the joints rest [m], (n, 3) float64
    centre   origin of the skeleton [m], (3,)
    dual     vertices skinned by dual quaternions, (n,) bool
    keys     of its blend shapes
    """

    painted: Painted
    joints: np.ndarray
    weights: np.ndarray
    bound: np.ndarray
    centre: np.ndarray
    dual: np.ndarray
    keys: list[Key]


def read(path: Path, prim: str | None, time: float | None = None, absent: Absent = "refuse") -> Body:
    """Read the visible meshes at or under a prim as one body; see `hairpipe.io.usd.read.read_body`."""
    with usd_faults(path):
        stage = open_whole(path, prim, absent)
        go_to(stage, time)
        meshes = [UsdGeom.Mesh(p) for p in shown(stage, prim, UsdGeom.Mesh)]
        bindings = find_bindings(stage)
        rigs = _read_rigs([bindings[mesh.GetPath()] for mesh in meshes if mesh.GetPath() in bindings])
        animated = find_bindings(stage, shapes=True)
        animators = [animated.get(mesh.GetPath()) for mesh in meshes]
        names = name_weights(meshes, animators)
        pieces = [
            _read_piece(mesh, bindings.get(mesh.GetPath()), rigs, _Shapes(animator, names))
            for mesh, animator in zip(meshes, animators, strict=True)
        ]
        for mesh in meshes:
            warn_of_scheme(mesh)
        time = read_time([mesh.GetPrim() for mesh in meshes if mesh.GetPath() not in bindings], time)
    mesh = merge_meshes([piece.painted.mesh for piece in pieces])
    joints = stack_influences([piece.joints for piece in pieces])
    weights = stack_influences([piece.weights for piece in pieces])
    painted = [piece.painted for piece in pieces]
    counts = [len(p.mesh.points) for p in painted]
    maps = merge_maps([p.maps for p in painted], counts)
    turns = np.concatenate([np.empty((0, 4, 4)), *(rig.turns for rig in rigs.values())])
    dual = np.flatnonzero(np.concatenate([piece.dual for piece in pieces])).astype(np.int32)
    centres = np.repeat([piece.centre for piece in pieces], counts, axis=0)[dual]
    return Body(
        mesh,
        join_rigs(list(rigs.values())),
        joints,
        weights,
        maps,
        time,
        DualQuaternions(dual, centres) if len(dual) else None,
        join_shapes([piece.keys for piece in pieces], counts, {}),
        Bound(np.concatenate([piece.bound for piece in pieces]), turns) if (turns != np.eye(4)).any() else None,
    )


def _read_rigs(bindings: Sequence[Binding]) -> dict[Sdf.Path, Rig]:
    rigs: dict[Sdf.Path, Rig] = {}
    for binding in bindings:
        if binding.skeleton.GetPrim().GetPath() not in rigs:
            first = sum(len(rig.joints) for rig in rigs.values())
            rigs[binding.skeleton.GetPrim().GetPath()] = read_rig(binding.skeleton, first)
    return rigs


@dataclass(frozen=True)
class _Shapes:
    """What animates the blend shapes of a mesh, and the names of their weights."""

    binding: Binding | None
    names: Names

    def read(self, mesh: UsdGeom.Mesh, matrix: np.ndarray, n: int) -> list[Key]:
        if not has_blend_shapes(mesh):
            return []
        if self.binding is not None:
            return read_keys(mesh, self.binding, self.names, matrix, n)
        message = f"{mesh.GetPath()} has blend shapes without a Skeleton to animate them, which are ignored"
        warnings.warn(message, stacklevel=3)
        return []


def _read_piece(mesh: UsdGeom.Mesh, binding: Binding | None, rigs: dict[Sdf.Path, Rig], shapes: _Shapes) -> Piece:
    points = numbers(mesh.GetPointsAttr(), 3)
    n = len(points)
    if binding is None:
        if rigs:
            warnings.warn(f"{mesh.GetPath()} is not bound to a skeleton, and follows the first joint", stacklevel=2)
        painted = read_mesh(mesh, points, place(mesh.GetPrim()))
        k = min(len(rigs), 1)
        unturn = np.linalg.inv(next(iter(rigs.values())).turns[0]) if rigs else np.eye(4)
        keys = shapes.read(mesh, unturn @ place(mesh.GetPrim()), n)
        bound = move(unturn, painted.mesh.points)
        return Piece(painted, np.zeros((n, k), np.int32), np.ones((n, k)), bound, np.zeros(3), np.zeros(n, bool), keys)
    rig = rigs[binding.skeleton.GetPrim().GetPath()]
    joints, weights = read_influences(rig, binding.skinning, n)
    painted = read_mesh(mesh, skin_at_rest(rig, binding.skinning, points, joints, weights), rig.matrix)
    first = np.take_along_axis(joints, weights.argmax(axis=1)[:, None], axis=1)
    bends = ((joints != first) & (weights > 0.0)).any(axis=1)
    dual = bends & (binding.skinning.GetSkinningMethod() == UsdSkel.Tokens.dualQuaternion)
    matrix = rig.matrix @ columns(binding.skinning.GetGeomBindTransform(REST))
    keys = shapes.read(mesh, matrix, n)
    return Piece(painted, joints, weights, move(matrix, points), rig.matrix[:3, 3], dual, keys)
