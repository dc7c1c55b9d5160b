"""Polygon meshes of a stage, with the maps on their vertices: bodies at rest, and animated meshes."""

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel, Vt

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at, sampled
from hairpipe.formats.polygons import Polygons, join_polygons, triangulate, warn_of_cage
from hairpipe.formats.rigging import Key, Part, join_parts
from hairpipe.formats.usd.skeleton import (
    REST,
    Binding,
    Names,
    Rig,
    filled,
    find_bindings,
    has_blend_shapes,
    join_rigs,
    name_weights,
    read_influences,
    read_keys,
    read_rig,
    skin_at_rest,
    turn_codes,
    weight_codes,
)
from hairpipe.formats.usd.stage import (
    checked,
    columns,
    go_to,
    list_files,
    location,
    move,
    numbers,
    open_whole,
    place,
    read_time,
    shown,
    spaces_of,
    time_of,
    transform_codes,
    usd_faults,
    with_folders,
)
from hairpipe.plain_file import Absent
from hairpipe.values import Body, DualQuaternions, Mesh

PER_VERTEX = (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying)
SKINNING = "skel:"  # prefix of the names of joint indices and weights
KNOWN = ("st", "displayColor", "displayOpacity")
SCALARS = (Sdf.ValueTypeNames.FloatArray, Sdf.ValueTypeNames.DoubleArray, Sdf.ValueTypeNames.HalfArray)


Maps = dict[str, np.ndarray]
"""Painted values of n vertices by name, each (n,) float64 in 0..1."""


def _read_mesh(prim: UsdGeom.Mesh, points: np.ndarray, matrix: np.ndarray) -> tuple[Polygons, Maps]:
    """Read faces without holes, texture coordinates and maps of a mesh, whose points a matrix takes to metres."""
    counts = numbers(prim.GetFaceVertexCountsAttr(), kind=np.int64)
    vertices = numbers(prim.GetFaceVertexIndicesAttr(), kind=np.int64)
    _check_faces(prim, counts, vertices, len(points))
    uv = _read_uv(prim, vertices, len(points))
    solid = _solid_faces(prim, len(counts))
    kept = np.repeat(solid, counts)
    points = move(matrix, points)
    vertices = vertices[kept]
    corners = triangulate(points[vertices], counts[solid])
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    if mirrored != (prim.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded):
        corners = corners[:, ::-1]
    triangles = np.ascontiguousarray(vertices[corners], np.int32)
    mesh = Mesh(points, triangles, uv=None if uv is None else np.ascontiguousarray(uv[kept][corners]))
    maps = _read_maps(prim, len(points))
    _warn_of_unused(prim, maps)
    kept = np.flatnonzero(solid)
    return Polygons(mesh, np.repeat(kept, counts[kept] - 2)), maps


def warn_of_scheme(prim: UsdGeom.Mesh) -> None:
    """Warn of an authored subdivision scheme that makes another surface; catmullClark by default may not be meant."""
    scheme = prim.GetSubdivisionSchemeAttr()
    if scheme.HasAuthoredValue() and scheme.Get() in (UsdGeom.Tokens.catmullClark, UsdGeom.Tokens.loop):
        points = numbers(prim.GetPointsAttr(), 3)
        counts = numbers(prim.GetFaceVertexCountsAttr(), kind=np.int64)
        vertices = numbers(prim.GetFaceVertexIndicesAttr(), kind=np.int64)
        _check_faces(prim, counts, vertices, len(points))
        warn_of_cage(location(prim.GetPrim()), points, counts, vertices, scheme.Get())


def _warn_of_unused(prim: UsdGeom.Mesh, maps: dict[str, np.ndarray]) -> None:
    """Name the primvars that are neither maps, nor texture coordinates, skinning or colours."""
    names = [primvar.GetPrimvarName() for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues()]
    unused = [name for name in names if name not in (*maps, *KNOWN) and not name.startswith(SKINNING)]
    if unused:
        message = f"primvars that are not used: {', '.join(sorted(unused))}"
        warnings.warn(f"{location(prim.GetPrim())}: {message}", stacklevel=2)


def _check_faces(prim: UsdGeom.Mesh, counts: np.ndarray, vertices: np.ndarray, n: int) -> None:
    where = location(prim.GetPrim())
    if not (n and len(counts)):
        raise BadInput("the mesh has no points or no faces", where=where, right="at least one face")
    if counts.min() < 3:
        raise BadInput(f"face {np.argmin(counts)} has {counts.min()} corners", where=where, right="3 or more")
    if counts.sum() != len(vertices):
        right = f"the sum of faceVertexCounts, {counts.sum()}"
        raise BadInput(f"faceVertexIndices has {len(vertices)} elements", where=where, right=right)
    if vertices.min() < 0 or vertices.max() >= n:
        bad = vertices[(vertices < 0) | (vertices >= n)][0]
        raise BadInput(f"faceVertexIndices names point {bad}", where=where, right=f"0 to {n - 1}")


def _solid_faces(prim: UsdGeom.Mesh, count: int) -> np.ndarray:
    """Return which faces are not holes, (count,) bool."""
    holes = numbers(prim.GetHoleIndicesAttr(), kind=np.int64)
    where = location(prim.GetPrim())
    if len(holes) and (holes.min() < 0 or holes.max() >= count):
        raise BadInput("holeIndices has an index without a face", where=where, right=f"0 to {count - 1}")
    solid = np.ones(count, bool)
    solid[holes] = False
    if not solid.any():
        raise BadInput("all faces are holes", where=where, right="at least one face")
    return solid


def _read_uv(prim: UsdGeom.Mesh, vertices: np.ndarray, n: int) -> np.ndarray | None:
    """Return the texture coordinates `st` of the face corners, (c, 2) float32; None, with a warning, for others."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    if not primvar.HasValue():
        return None
    values = _flat(primvar, 2).astype(np.float32)
    is_vertex = primvar.GetInterpolation() in PER_VERTEX
    try:
        _check_count(primvar, values, n if is_vertex else len(vertices))
    except BadInput as fault:
        message = f"{fault.where} {fault.what}, not {fault.right}: the mesh is read without texture coordinates"
        warnings.warn(message, stacklevel=3)
        return None
    return values[vertices] if is_vertex else values


def _read_maps(prim: UsdGeom.Mesh, n: int) -> dict[str, np.ndarray]:
    primvars = UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues()
    scalars = [p for p in primvars if p.GetInterpolation() in PER_VERTEX and p.GetTypeName() in SCALARS]
    painted = [p for p in scalars if p.GetElementSize() == 1 and not p.GetPrimvarName().startswith(SKINNING)]
    return {p.GetPrimvarName(): _read_map(p, n) for p in painted}


def _read_map(primvar: UsdGeom.Primvar, n: int) -> np.ndarray:
    values = _flat(primvar, 1)
    _check_count(primvar, values, n)
    if values.min() < 0 or values.max() > 1:
        name = primvar.GetPrimvarName()
        warnings.warn(f"map {name} spans {values.min():g} to {values.max():g}; clipped to 0..1", stacklevel=2)
    return values.clip(0, 1)


def _flat(primvar: UsdGeom.Primvar, columns: int) -> np.ndarray:
    return checked(primvar.ComputeFlattened(time_of(primvar.GetAttr().GetPrim())), primvar.GetAttr(), columns)


def _check_count(primvar: UsdGeom.Primvar, values: np.ndarray, right: int) -> None:
    if len(values) != right:
        where = f"{location(primvar.GetAttr().GetPrim())}.{primvar.GetName()}"
        right_count = f"{right} for {primvar.GetInterpolation()} interpolation"
        raise BadInput(f"has {len(values)} elements", where=where, right=right_count)


def read_body(path: Path, prim: str | None = None, time: float | None = None, absent: Absent = "refuse") -> Body:
    """Read the meshes of a stage as one body at rest, with the UsdSkel skeletons that move them.

    Polygons are triangulated. Float primvars on vertices become maps, `st` texture coordinates; invisible meshes and
    those of purpose proxy or guide are omitted. Bound meshes are in the rest pose of their skeleton, others in their
    pose at one time; without any skeleton the body has no joints.

    prim    path of a mesh or of a parent of meshes; by default the whole stage
    time    time code; by default the first at which all meshes and curves have samples, and a warning if the body moves
    absent  whether absent files of the stage are refused, or warned of

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim.
    """
    with usd_faults(path):
        stage = open_whole(path, prim, absent)
        go_to(stage, time)
        meshes = [UsdGeom.Mesh(p) for p in shown(stage, prim, UsdGeom.Mesh)]
        bindings = find_bindings(stage)
        rigs = _read_rigs([bindings[mesh.GetPath()] for mesh in meshes if mesh.GetPath() in bindings])
        animated = find_bindings(stage, shapes=True)
        animators = [animated.get(mesh.GetPath()) for mesh in meshes]
        names = name_weights(meshes, animators)
        parts = list[Part]()
        centres, dual = list[np.ndarray](), list[np.ndarray]()
        for mesh, animator in zip(meshes, animators, strict=True):
            binding = bindings.get(mesh.GetPath())
            part = _read_part(mesh, binding, rigs, animator, names)
            parts.append(part)
            rig = None if binding is None else rigs[binding.skeleton.GetPrim().GetPath()]
            centres.append(np.zeros(3) if rig is None else rig.matrix[:3, 3])
            dual.append(_is_dual(binding, part))
        for mesh in meshes:
            warn_of_scheme(mesh)
        time = read_time([mesh.GetPrim() for mesh in meshes if mesh.GetPath() not in bindings], time)
    turns = np.concatenate([np.empty((0, 4, 4)), *(rig.turns for rig in rigs.values())])
    blended = np.flatnonzero(np.concatenate(dual)).astype(np.int32)
    about = np.repeat(centres, [len(part.bound) for part in parts], axis=0)[blended]
    quaternions = DualQuaternions(blended, about) if len(blended) else None
    return join_parts(parts, join_rigs(list(rigs.values())), turns, {}, time, quaternions)


def _read_rigs(bindings: Sequence[Binding]) -> dict[Sdf.Path, Rig]:
    rigs: dict[Sdf.Path, Rig] = {}
    for binding in bindings:
        if binding.skeleton.GetPrim().GetPath() not in rigs:
            first = sum(len(rig.joints) for rig in rigs.values())
            rigs[binding.skeleton.GetPrim().GetPath()] = read_rig(binding.skeleton, first)
    return rigs


def _read_part(
    mesh: UsdGeom.Mesh, binding: Binding | None, rigs: dict[Sdf.Path, Rig], animator: Binding | None, names: Names
) -> Part:
    """Read a mesh, which a binding to a skeleton moves, and blend shapes, which another may animate."""
    points = numbers(mesh.GetPointsAttr(), 3)
    n = len(points)
    if binding is None:
        if rigs:
            warnings.warn(f"{mesh.GetPath()} is not bound to a skeleton, and follows the first joint", stacklevel=2)
        (triangles, _), maps = _read_mesh(mesh, points, place(mesh.GetPrim()))
        k = min(len(rigs), 1)
        joints = np.zeros((n, k), np.int32)
        weights = np.ones((n, k))
        unturn = np.linalg.inv(next(iter(rigs.values())).turns[0]) if rigs else np.eye(4)
        matrix = unturn @ place(mesh.GetPrim())
        bound = move(unturn, triangles.points)
    else:
        rig = rigs[binding.skeleton.GetPrim().GetPath()]
        joints, weights = read_influences(rig, binding.skinning, n)
        rest = skin_at_rest(rig, binding.skinning, points, joints, weights)
        (triangles, _), maps = _read_mesh(mesh, rest, rig.matrix)
        matrix = rig.matrix @ columns(binding.skinning.GetGeomBindTransform(REST))
        bound = move(matrix, points)
    keys = list[Key]()
    if has_blend_shapes(mesh) and animator is not None:
        keys = read_keys(mesh, animator, names, matrix, n)
    elif has_blend_shapes(mesh):
        message = f"{mesh.GetPath()} has blend shapes without a Skeleton to animate them, which are ignored"
        warnings.warn(message, stacklevel=3)
    return Part(triangles, maps, joints, weights, bound, keys)


def _is_dual(binding: Binding | None, part: Part) -> np.ndarray:
    """Return the vertices that dual quaternions bend: those of several joints, (n,) bool."""
    if binding is None or binding.skinning.GetSkinningMethod() != UsdSkel.Tokens.dualQuaternion:
        return np.zeros(len(part.bound), bool)
    first = np.take_along_axis(part.joints, part.weights.argmax(axis=1)[:, None], axis=1)
    return ((part.joints != first) & (part.weights > 0.0)).any(axis=1)


def read_moving(path: Path, prim: str | None, instant: Instant, absent: Absent = "refuse") -> Polygons:
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
        return join_polygons([_read_mesh(mesh, *_points(mesh, binding))[0] for mesh, binding in pairs])

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
