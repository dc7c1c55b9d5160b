"""Polygon meshes of a stage as triangles in metres, with the maps on their vertices."""

import warnings
from dataclasses import dataclass

import numpy as np
from pxr import Sdf, UsdGeom

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.io.polygons import triangulate
from hairpipe.io.subdivision import warn_of_cage
from hairpipe.io.usd.stage import checked, location, move, numbers, time_of

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
