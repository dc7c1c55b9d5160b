"""Polygon meshes of a stage as triangles in metres with Y up, with the maps on their vertices, and bodies of them."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdGeom, UsdSkel

from hairpipe.errors import BadInput
from hairpipe.formats.polygons import triangulate, warn_of_cage
from hairpipe.formats.rigging import Key, Part, join_parts
from hairpipe.formats.usd.skeleton import (
    REST,
    Binding,
    Names,
    Rig,
    find_bindings,
    has_blend_shapes,
    join_rigs,
    name_weights,
    read_influences,
    read_keys,
    read_rig,
    skin_at_rest,
)
from hairpipe.formats.usd.stage import (
    checked,
    columns,
    go_to,
    location,
    move,
    numbers,
    open_whole,
    place,
    read_time,
    shown,
    time_of,
    usd_faults,
)
from hairpipe.plain_file import Absent
from hairpipe.values import Body, DualQuaternions, Mesh

PER_VERTEX = (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying)
SKINNING = "skel:"  # prefix of the names of joint indices and weights
KNOWN = ("st", "displayColor", "displayOpacity")
SCALARS = (Sdf.ValueTypeNames.FloatArray, Sdf.ValueTypeNames.DoubleArray, Sdf.ValueTypeNames.HalfArray)


@dataclass(frozen=True)
class Painted:
    """A mesh and the maps on its n vertices, each (n,) float64 in 0..1."""

    mesh: Mesh
    maps: dict[str, np.ndarray]


def read_mesh(prim: UsdGeom.Mesh, points: np.ndarray, matrix: np.ndarray) -> Painted:
    """Read the faces, texture coordinates and maps of a mesh whose points (n, 3) the matrix (4, 4) takes to metres.

    Polygons are triangulated, counter-clockwise seen from outside, without holes.

    Raises BadInput if counts, indices and points do not agree.
    """
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
    return Painted(mesh, maps)


def warn_of_scheme(prim: UsdGeom.Mesh) -> None:
    """Warn of a mesh whose authored subdivision scheme makes another surface of it than its polygons.

    Every mesh has the scheme catmullClark by default; that of a file without one is not known to be meant.
    """
    scheme = prim.GetSubdivisionSchemeAttr()
    if scheme.HasAuthoredValue() and scheme.Get() in (UsdGeom.Tokens.catmullClark, UsdGeom.Tokens.loop):
        points = numbers(prim.GetPointsAttr(), 3)
        counts = numbers(prim.GetFaceVertexCountsAttr(), kind=np.int64)
        vertices = numbers(prim.GetFaceVertexIndicesAttr(), kind=np.int64)
        _check_faces(prim, counts, vertices, len(points))
        warn_of_cage(location(prim.GetPrim()), points, counts, vertices, scheme.Get())


def polygon_owners(prim: UsdGeom.Mesh) -> np.ndarray:
    """Return the polygon of each triangle that `read_mesh` gives, (m,) int64."""
    counts = numbers(prim.GetFaceVertexCountsAttr(), kind=np.int64)
    solid = np.flatnonzero(_solid_faces(prim, len(counts)))
    return np.repeat(solid, counts[solid] - 2)


def _warn_of_unused(prim: UsdGeom.Mesh, maps: dict[str, np.ndarray]) -> None:
    """Name the primvars that are neither maps, nor texture coordinates, skinning or colours."""
    names = [primvar.GetPrimvarName() for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues()]
    unused = [name for name in names if name not in (*maps, *KNOWN) and not name.startswith(SKINNING)]
    if unused:
        warnings.warn(
            f"{location(prim.GetPrim())}: primvars that are not used: {', '.join(sorted(unused))}", stacklevel=2
        )


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
        painted = read_mesh(mesh, points, place(mesh.GetPrim()))
        k = min(len(rigs), 1)
        joints, weights = np.zeros((n, k), np.int32), np.ones((n, k))
        unturn = np.linalg.inv(next(iter(rigs.values())).turns[0]) if rigs else np.eye(4)
        matrix = unturn @ place(mesh.GetPrim())
        bound = move(unturn, painted.mesh.points)
    else:
        rig = rigs[binding.skeleton.GetPrim().GetPath()]
        joints, weights = read_influences(rig, binding.skinning, n)
        painted = read_mesh(mesh, skin_at_rest(rig, binding.skinning, points, joints, weights), rig.matrix)
        matrix = rig.matrix @ columns(binding.skinning.GetGeomBindTransform(REST))
        bound = move(matrix, points)
    keys = list[Key]()
    if has_blend_shapes(mesh) and animator is not None:
        keys = read_keys(mesh, animator, names, matrix, n)
    elif has_blend_shapes(mesh):
        message = f"{mesh.GetPath()} has blend shapes without a Skeleton to animate them, which are ignored"
        warnings.warn(message, stacklevel=3)
    return Part(painted.mesh, painted.maps, joints, weights, bound, keys)


def _is_dual(binding: Binding | None, part: Part) -> np.ndarray:
    """Return the vertices that dual quaternions bend: those of several joints, (n,) bool."""
    if binding is None or binding.skinning.GetSkinningMethod() != UsdSkel.Tokens.dualQuaternion:
        return np.zeros(len(part.bound), bool)
    first = np.take_along_axis(part.joints, part.weights.argmax(axis=1)[:, None], axis=1)
    return ((part.joints != first) & (part.weights > 0.0)).any(axis=1)
