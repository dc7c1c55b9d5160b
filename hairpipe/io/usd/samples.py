"""Samples of a shot: points, velocities, locks, normals and extents, checked before they are written."""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.errors import BadInput
from hairpipe.spatial.triangles import vertex_normals

NAMED = 5  # number of strands or vertices in a message


def locks_of(state: HairState, groom: Groom | None, strands: int) -> np.ndarray:
    """Return the id of the guide of each strand, its own for a simulated one, (S,); pure.

    Raises BadInput where the state is of other hair.
    """
    leaders = state.leaders(strands)
    if len(leaders) != strands:
        raise BadInput("the states are not those of the hair", where="states", right="those of its simulation")
    return leaders if groom is None else groom.ids[leaders]


def declare_locks(prim: UsdGeom.BasisCurves) -> UsdGeom.Primvar:
    """Declare the primvar of the guides of strands."""
    api = UsdGeom.PrimvarsAPI(prim)
    return api.CreatePrimvar("lockId", Sdf.ValueTypeNames.IntArray, UsdGeom.Tokens.uniform)


def sample_hair(
    prim: UsdGeom.BasisCurves, frame: int, strands: Strands, first: Strands, locks: np.ndarray | None
) -> int:
    """Author the hair at a frame; returns the bytes.

    locks  guides of the strands, (S,), see `locks_of`
    first  hair at the first frame, with the same strands

    Raises BadInput if strands have changed, or have points that are not finite, naming them and the frame.
    """
    where = f"hair at frame {frame}"
    if not np.array_equal(strands.offsets, first.offsets):
        raise BadInput("the strands are not those of the first frame", where=where, right="the same points per strand")
    for name, array in (("points", strands.points), ("velocities", strands.velocities)):
        bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
        owners = np.unique(np.searchsorted(strands.offsets, bad, side="right") - 1)
        _refuse(f"strand{'s'[: len(owners) != 1]}", owners, name, where)
    time = Usd.TimeCode(frame)
    prim.GetPointsAttr().Set(vectors(strands.points), time)
    prim.GetVelocitiesAttr().Set(vectors(strands.velocities), time)
    prim.GetExtentAttr().Set(extent(strands.points, strands.diameter / 2), time)
    if locks is not None:
        declare_locks(prim).Set(integers(locks), time)
    return strands.points.nbytes + strands.velocities.nbytes


def hold_hair(prim: UsdGeom.BasisCurves, strands: Strands, locks: np.ndarray | None) -> None:
    """Author the points and their extent as defaults, for clients that read only these."""
    prim.GetPointsAttr().Set(vectors(strands.points))
    prim.GetExtentAttr().Set(extent(strands.points, strands.diameter / 2))
    if locks is not None:
        declare_locks(prim).Set(integers(locks))


def hold_body(prim: UsdGeom.Mesh, mesh: Mesh) -> None:
    """Author the points, normals and extent as defaults, for clients that read only these."""
    prim.GetPointsAttr().Set(vectors(mesh.points))
    prim.GetNormalsAttr().Set(vectors(vertex_normals(mesh)))
    prim.GetExtentAttr().Set(extent(mesh.points, 0.0))


def sample_body(prim: UsdGeom.Mesh, frame: int, mesh: Mesh, first: Mesh) -> int:
    """Author the body at a frame; returns the bytes.

    first  body at the first frame, with the same triangles

    Raises BadInput if the triangles have changed, or points are not finite, naming vertices and the frame.
    """
    where = f"body at frame {frame}"
    if not np.array_equal(mesh.triangles, first.triangles) or len(mesh.points) != len(first.points):
        raise BadInput("the triangles are not those of the first frame", where=where, right="the same triangles")
    time = Usd.TimeCode(frame)
    _refuse("vertices", np.flatnonzero(~np.isfinite(mesh.points).all(axis=1)), "points", where)
    prim.GetPointsAttr().Set(vectors(mesh.points), time)
    if mesh.velocities is not None:
        _refuse("vertices", np.flatnonzero(~np.isfinite(mesh.velocities).all(axis=1)), "velocities", where)
        prim.GetVelocitiesAttr().Set(vectors(mesh.velocities), time)
    prim.GetNormalsAttr().Set(vectors(vertex_normals(mesh)), time)
    prim.GetExtentAttr().Set(extent(mesh.points, 0.0), time)
    return 36 * len(mesh.points)


def _refuse(whose: str, bad: np.ndarray, what: str, where: str) -> None:
    if len(bad):
        listed = ", ".join(map(str, bad[:NAMED])) + (f" and {len(bad) - NAMED} more" if len(bad) > NAMED else "")
        raise BadInput(f"{what} of {whose} {listed} are not finite", where=where, right="finite numbers")


def vectors(array: np.ndarray) -> Vt.Vec3fArray:
    """Convert an array (n, 3) to USD, in single precision."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, np.float32))


def integers(array: np.ndarray) -> Vt.IntArray:
    """Convert an array of integers, (n,), to USD."""
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(array, np.int32))


def extent(points: np.ndarray, padding: float) -> Vt.Vec3fArray:
    """Return lower and upper corner of the box of the points (n, 3) [m], with a padding [m] on all sides."""
    if not len(points):
        return Vt.Vec3fArray([Gf.Vec3f(0), Gf.Vec3f(0)])
    points = np.asarray(points, np.float32)
    return vectors(np.stack([points.min(axis=0) - padding, points.max(axis=0) + padding]))
