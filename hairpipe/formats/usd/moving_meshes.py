"""Animated meshes of a stage: samples of points, transforms, skeletons and blend shapes, as OpenUSD bakes them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel, Vt

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at, sampled
from hairpipe.formats.polygons import Polygons, join_polygons
from hairpipe.formats.usd.layer_files import list_files, with_folders
from hairpipe.formats.usd.meshes import polygon_owners, read_mesh, warn_of_scheme
from hairpipe.formats.usd.skeleton import Binding, filled, find_bindings, turn_codes, weight_codes
from hairpipe.formats.usd.stage import (
    columns,
    location,
    move,
    numbers,
    open_whole,
    place,
    shown,
    spaces_of,
    time_of,
    transform_codes,
    usd_faults,
)
from hairpipe.plain_file import Absent


def read(path: Path, prim: str | None, instant: Instant, absent: Absent = "refuse") -> Polygons:
    """Read the visible meshes at or under a prim, or those that a pattern names, at an instant."""
    with usd_faults(path):
        return read_at(recall(MovingMeshes, path, prim, absent), instant)


class MovingMeshes:
    """Samples of the meshes of a stage in metres with Y up, see `animated_meshes.Samples`.

    Raises BadInput for a stage without meshes, or with a PointInstancer among them.
    """

    def __init__(self, path: Path, prim: str | None, absent: Absent = "refuse") -> None:
        self.stage = open_whole(path, prim, absent)
        self.files = with_folders(list_files(path))
        self.meshes = [UsdGeom.Mesh(p) for p in shown(self.stage, prim, UsdGeom.Mesh)]
        _refuse_instancers(self.stage, self.meshes, prim)
        bindings = find_bindings(self.stage, shapes=True)
        self.bindings = [bindings.get(mesh.GetPath()) for mesh in self.meshes]
        self.rate = self.stage.GetTimeCodesPerSecond()
        self.codes = self._find_codes()
        self.own = [self._has_velocities(*pair) for pair in zip(self.meshes, self.bindings, strict=True)]
        self._go_to(self.codes[0])
        self.polygons = [_polygons(mesh) for mesh in self.meshes]
        for mesh in self.meshes:
            warn_of_scheme(mesh)

    def shape(self, sample: int) -> Polygons:
        self._go_to(self.codes[sample])
        pairs = zip(self.meshes, self.bindings, strict=True)
        return join_polygons([Polygons(read_mesh(m, *_points(m, b)).mesh, polygon_owners(m)) for m, b in pairs])

    def sample(self, sample: int) -> list[Points]:
        """Read the points of the meshes at a sample; BadInput where polygons are not those of the first one."""
        self._go_to(self.codes[sample])
        found = list[Points]()
        for mesh, binding, has, first in zip(self.meshes, self.bindings, self.own, self.polygons, strict=True):
            if any(not np.array_equal(*pair) for pair in zip(_polygons(mesh), first, strict=True)):
                where = f"{location(mesh.GetPrim())} at time code {self.codes[sample]:g}"
                right = f"those of time code {self.codes[0]:g} at all times"
                raise BadInput("the polygons have changed", where=where, right=right)
            points, matrix = _points(mesh, binding)
            velocities = numbers(mesh.GetVelocitiesAttr(), 3) @ matrix[:3, :3].T if has else None
            if velocities is not None and len(velocities) != len(points):
                where = f"{location(mesh.GetPrim())} at time code {self.codes[sample]:g}"
                raise BadInput(f"there are {len(velocities)} velocities", where=where, right=f"{len(points)}")
            found.append((move(matrix, points), velocities))
        return found

    def _go_to(self, code: float) -> None:
        self.stage.GetSessionLayer().startTimeCode = code

    def _has_velocities(self, mesh: UsdGeom.Mesh, binding: Binding | None) -> bool:
        """Return whether velocities are used: in a moving space or on a skeleton, they are not all of the motion."""
        moves = any(space.TransformMightBeTimeVarying() for space in spaces_of(mesh.GetPrim()))
        return mesh.GetVelocitiesAttr().HasValue() and binding is None and not moves

    def _find_codes(self) -> np.ndarray:
        """Return the time codes of all samples of points, of transforms above them, and of their skeletons."""
        points = list[Sequence[float]]()
        turns = list[Sequence[float]]()
        for mesh, binding in zip(self.meshes, self.bindings, strict=True):
            points += mesh.GetPointsAttr().GetTimeSamples(), mesh.GetVelocitiesAttr().GetTimeSamples()
            turns += transform_codes(mesh.GetPrim())
            if binding is not None:
                turns += turn_codes(binding.skeleton)
                points.append(weight_codes(binding.skeleton))
        constant = {code for group in (*points, *turns) for code in group}
        return np.array(sorted(sampled(points) | filled(sampled(turns)) or constant or {0.0}))


def _polygons(mesh: UsdGeom.Mesh) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the sizes and corners of the polygons, and the number of points, at the time of the stage."""
    sizes = numbers(mesh.GetFaceVertexCountsAttr(), kind=np.int64)
    return sizes, numbers(mesh.GetFaceVertexIndicesAttr(), kind=np.int64), len(numbers(mesh.GetPointsAttr(), 3))


def _points(mesh: UsdGeom.Mesh, binding: Binding | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n, 3) in a space, and its matrix to metres (4, 4), at the time of the stage."""
    points = numbers(mesh.GetPointsAttr(), 3)
    if binding is None:
        return points, place(mesh.GetPrim())
    time = time_of(mesh.GetPrim())
    moved = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32))
    where = location(mesh.GetPrim())
    if binding.skinning.HasBlendShapes() and binding.skeleton.GetAnimQuery():
        _blend(mesh, binding, moved, time)
    if not binding.skinning.HasJointInfluences():
        return np.array(moved, np.float64), place(mesh.GetPrim())
    skeleton = binding.skeleton.ComputeSkinningTransforms(time)
    if not skeleton:
        raise BadInput("the joints have no transforms", where=where, right="a rest or bind pose, or an animation")
    matrix = place(binding.skeleton.GetPrim())
    if binding.skinning.IsRigidlyDeformed():
        rigid = binding.skinning.ComputeSkinnedTransform(skeleton, time)
        return np.array(moved, np.float64), matrix @ columns(rigid)
    if not binding.skinning.ComputeSkinnedPoints(skeleton, moved, time):
        raise BadInput("the mesh cannot be skinned", where=where, right="joint influences that fit points and joints")
    return np.array(moved, np.float64), matrix


def _blend(mesh: UsdGeom.Mesh, binding: Binding, points: Vt.Vec3fArray, time: Usd.TimeCode) -> None:
    shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(mesh))
    weights = binding.skeleton.GetAnimQuery().ComputeBlendShapeWeights(time)
    mapper = binding.skinning.GetBlendShapeMapper()
    weights = mapper.Remap(weights) if mapper else weights
    found = shapes.ComputeSubShapeWeights(weights)
    offsets = shapes.ComputeSubShapePointOffsets()
    if not found or not shapes.ComputeDeformedPoints(*found, shapes.ComputeBlendShapePointIndices(), offsets, points):
        right = "offsets and pointIndices that fit the points"
        raise BadInput("the blend shapes cannot be applied", where=location(mesh.GetPrim()), right=right)


def _refuse_instancers(stage: Usd.Stage, meshes: Sequence[UsdGeom.Mesh], prim: str | None) -> None:
    """Refuse a PointInstancer above a mesh, or among all shapes of the stage where all are read."""
    found = [p for p in stage.Traverse(Usd.TraverseInstanceProxies()) if p.IsA(UsdGeom.PointInstancer)]
    for instancer in found:
        if prim is None or any(mesh.GetPath().HasPrefix(instancer.GetPath()) for mesh in meshes):
            right = "its instances as meshes, or a group without it"
            raise BadInput("is a PointInstancer, which is not read", where=location(instancer), right=right)
