"""Polygon meshes of a stage as triangles in metres, with the maps on their vertices.

Body of a stage: its meshes as one, and their skeletons.

Bodies and grooms from USD files (usd, usda, usdc, usdz), in metres with Y up.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdGeom, UsdSkel

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.formats.polygons import merge_meshes, triangulate
from hairpipe.formats.rigging import Key, join_shapes, merge_maps, stack_influences, warn_of_cage
from hairpipe.formats.usd import curves
from hairpipe.formats.usd import meshes as skinned_meshes
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
from hairpipe.values import Body, Bound, DualQuaternions, Mesh
from hairpipe.values.groom import Curves

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
    """Return the texture coordinates `st` of the face corners, (c, 2) float32; None without.

    Warns of another number of them, as a mesh with edited faces may have.
    """
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
    """Read the visible meshes at or under a prim as one body; see `hairpipe.formats.usd.meshes.read_body`."""
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
    return work_apart(skinned_meshes.read, path, prim, time, absent)


def read_curves(
    path: Path,
    prim: str | None = None,
    time: float | None = None,
    guides: bool = False,
    absent: Absent = "refuse",
) -> Curves:
    """Read all BasisCurves and cubic NurbsCurves of a stage at one time as strands, root first.

    Invisible curves and those of purpose proxy are omitted; those of purpose guide, too, where there are others.
    Linear and Catmull-Rom curves interpolate their points, which are returned unchanged; B-splines, Bezier curves and
    NURBS are evaluated. Those without pins are returned with the ends of pinned ones, as spare points. The
    rest shape is that of primvar `pref` or `rest`, ids are those of `hairId`, `groom_id` or `id`.

    prim    path of curves or of a parent of curves; by default the whole stage
    time    as of `read_body`
    guides  whether curves of purpose guide are read in any case
    absent  as of `read_body`

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim and the curve.
    """
    return work_apart(curves.read, path, prim, time, guides, absent)
