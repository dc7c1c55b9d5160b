"""Body of a stage: its meshes as one, and their skeletons."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdGeom

from hairpipe.data import Body
from hairpipe.io.polygons import merge_meshes
from hairpipe.io.rigging import merge_maps, stack_influences
from hairpipe.io.usd.meshes.mesh import Painted, read_mesh
from hairpipe.io.usd.meshes.skeleton import (
    Binding,
    Rig,
    find_bindings,
    has_blend_shapes,
    join_rigs,
    read_influences,
    read_rig,
    skin_at_rest,
)
from hairpipe.io.usd.stage import numbers, open_alone, place, read_time, shown, usd_faults


@dataclass(frozen=True)
class Piece:
    """One mesh of the body, n vertices, each following k joints of the whole skeleton.

    joints   (n, k) int32
    weights  (n, k) float64
    """

    painted: Painted
    joints: np.ndarray
    weights: np.ndarray


def read(path: Path, prim: str | None, time: float | None = None) -> Body:
    """Read the visible meshes at or under a prim as one body; see `hairpipe.io.usd.read.read_body`."""
    with usd_faults(path):
        stage = open_alone(path, time)
        meshes = [UsdGeom.Mesh(p) for p in shown(stage, prim, UsdGeom.Mesh)]
        bindings = find_bindings(stage)
        rigs = _read_rigs([bindings[mesh.GetPath()] for mesh in meshes if mesh.GetPath() in bindings])
        pieces = [_read_piece(mesh, bindings.get(mesh.GetPath()), rigs) for mesh in meshes]
        time = read_time([mesh.GetPrim() for mesh in meshes if mesh.GetPath() not in bindings], time)
    mesh = merge_meshes([piece.painted.mesh for piece in pieces])
    joints = stack_influences([piece.joints for piece in pieces])
    weights = stack_influences([piece.weights for piece in pieces])
    painted = [piece.painted for piece in pieces]
    maps = merge_maps([p.maps for p in painted], [len(p.mesh.points) for p in painted])
    return Body(mesh, join_rigs(list(rigs.values())), joints, weights, maps, time)


def _read_rigs(bindings: Sequence[Binding]) -> dict[Sdf.Path, Rig]:
    rigs: dict[Sdf.Path, Rig] = {}
    for binding in bindings:
        if binding.skeleton.GetPrim().GetPath() not in rigs:
            first = sum(len(rig.joints) for rig in rigs.values())
            rigs[binding.skeleton.GetPrim().GetPath()] = read_rig(binding.skeleton, first)
    return rigs


def _read_piece(mesh: UsdGeom.Mesh, binding: Binding | None, rigs: dict[Sdf.Path, Rig]) -> Piece:
    points = numbers(mesh.GetPointsAttr(), 3)
    if has_blend_shapes(mesh):
        warnings.warn(f"{mesh.GetPath()} has blend shapes, which are ignored: the mesh is read at rest", stacklevel=2)
    if binding is None:
        if rigs:
            warnings.warn(f"{mesh.GetPath()} is not bound to a skeleton, and follows the first joint", stacklevel=2)
        painted = read_mesh(mesh, points, place(mesh.GetPrim()))
        k = min(len(rigs), 1)
        return Piece(painted, np.zeros((len(points), k), np.int32), np.ones((len(points), k)))
    rig = rigs[binding.skeleton.GetPrim().GetPath()]
    joints, weights = read_influences(rig, binding.skinning, len(points))
    painted = read_mesh(mesh, skin_at_rest(rig, binding.skinning, points, joints, weights), rig.matrix)
    return Piece(painted, joints, weights)
