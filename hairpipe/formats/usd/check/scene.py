"""Visible hair and meshes of a stage over time, one frame of one shape in memory at a time.

A shape at one time as arrays, read once and checked by many rules.

A shape over time, one frame of it in memory at a time.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from hairpipe.errors import BadInput
from hairpipe.formats.usd.skeleton import Binding, find_bindings
from hairpipe.formats.usd.stage import RENDERED, to_metres

TOKENS = UsdGeom.Tokens


class Snapshot:
    """Curves or a mesh at one time; an absent attribute, or one that is not an array of numbers, is None.

    curves  whether these are curves
    code    time code, or None for constant shapes
    """

    def __init__(self, prim: Usd.Prim, time: Usd.TimeCode) -> None:
        self.prim = prim
        self.time = time
        self.code = None if time.IsDefault() else time.GetValue()
        self.curves = prim.IsA(UsdGeom.BasisCurves)
        self._arrays: dict[str, np.ndarray | None] = {}

    def path(self, name: str) -> str:
        """Return the path of an attribute, for messages."""
        return f"{self.prim.GetPath()}.{name}"

    def array(self, name: str, columns: int = 1) -> np.ndarray | None:
        """Return a numeric array attribute, (n,) or (n, columns), as it is stored."""
        if name not in self._arrays:
            value = self.prim.GetAttribute(name).Get(self.time) if self.prim.HasAttribute(name) else None
            array = None if value is None else np.asarray(value)
            self._arrays[name] = array if array is not None and array.dtype.kind in "iuf" else None
        array = self._arrays[name]
        shape = () if columns == 1 else (columns,)
        return array if array is not None and array.ndim and array.shape[1:] == shape else None

    @cached_property
    def points(self) -> np.ndarray:
        """Return positions, (n, 3) float32; empty where they are absent."""
        points = self.array("points", 3)
        return np.empty((0, 3), np.float32) if points is None else points

    @cached_property
    def counts(self) -> np.ndarray:
        """Return the vertex counts of curves or faces, (c,) int64; empty where they are absent."""
        counts = self.array("curveVertexCounts" if self.curves else "faceVertexCounts")
        return np.empty(0, np.int64) if counts is None else counts.astype(np.int64)

    @cached_property
    def corners(self) -> np.ndarray:
        """Return the points at the corners of the faces, (k,) int32; empty where they are absent."""
        corners = self.array("faceVertexIndices")
        return np.empty(0, np.int32) if corners is None else corners

    @cached_property
    def consistent(self) -> bool:
        """Return whether counts and elements agree."""
        elements = self.points if self.curves else self.corners
        return bool(self.counts.sum() == len(elements) and (self.counts >= 0).all())

    @cached_property
    def sound(self) -> bool:
        """Return whether these are curves of two or more points each, all finite."""
        whole = self.curves and self.consistent and len(self.counts) and (self.counts > 1).all()
        return bool(whole and np.isfinite(self.points).all())

    @cached_property
    def world(self) -> np.ndarray:
        """Return the matrix from the shape to the world, which acts on row vectors, (4, 4) float64."""
        return np.array(UsdGeom.Xformable(self.prim).ComputeLocalToWorldTransform(self.time))

    @cached_property
    def placed(self) -> np.ndarray:
        """Return positions in the world, (n, 3) float64."""
        return self.points @ self.world[:3, :3] + self.world[3, :3]

    @cached_property
    def roots(self) -> np.ndarray:
        """Return the index of the first point of every curve, (c,) int64."""
        return np.cumsum(self.counts) - self.counts

    @cached_property
    def tips(self) -> np.ndarray:
        """Return the index of the last point of every curve, (c,) int64."""
        return np.cumsum(self.counts) - 1

    @cached_property
    def segments(self) -> np.ndarray:
        """Return the lengths of all segments of valid curves, one curve after the other, (n - c,) float64."""
        steps = np.linalg.norm(np.diff(self.points.astype(np.float64), axis=0), axis=1)
        return np.delete(steps, self.tips[:-1])

    @cached_property
    def lengths(self) -> np.ndarray:
        """Return the lengths of valid curves, (c,) float64."""
        return self.per_strand(np.add, self.segments)

    def per_strand(self, reduce: np.ufunc, values: np.ndarray) -> np.ndarray:
        """Reduce values of the segments, (n - c,), to one for every curve, (c,)."""
        return reduce.reduceat(values, self.roots - np.arange(len(self.counts)))

    def per_strand_of_points(self, values: np.ndarray) -> np.ndarray:
        """Return the sums of values of the points, (n,), over every curve, (c,)."""
        return np.add.reduceat(values, self.roots)

    def nearest_of_points(self, values: np.ndarray) -> np.ndarray:
        """Return the least of the values of the points, (n,), of every curve, (c,)."""
        return np.minimum.reduceat(values, self.roots)

    def size(self, interpolation: str) -> int:
        """Return the number of values of an interpolation."""
        if interpolation == TOKENS.constant:
            return 1
        if interpolation == TOKENS.uniform:
            return len(self.counts)
        if interpolation == TOKENS.faceVarying and not self.curves:
            return len(self.corners)
        if interpolation == TOKENS.vertex or not self.curves:
            return len(self.points)
        return UsdGeom.BasisCurves(self.prim).ComputeVaryingDataSize(self.time)


REST = (2 / 3, 3 / 2)
"""Accepted lengths at rest over those at the first time: a rest pose in the unit of the points."""


def notes_of(stage: Usd.Stage) -> dict[str, Any]:
    """Return our notes in a stage; none in the stage of another program."""
    notes = stage.GetRootLayer().customLayerData.get("hairpipe")
    return notes if isinstance(notes, dict) else {}


class Track:
    """A shape over time.

    prim   curves or a mesh
    times  codes of all samples; empty for a constant shape
    """

    def __init__(self, prim: Usd.Prim) -> None:
        self.prim = prim
        self.times = sorted({time for attribute in prim.GetAttributes() for time in attribute.GetTimeSamples()})

    def at(self, time: float | None) -> Snapshot:
        """Return the shape at a time code, or a constant shape."""
        return Snapshot(self.prim, Usd.TimeCode.Default() if time is None else Usd.TimeCode(time))

    def path(self, name: str) -> str:
        """Return the path of an attribute, for messages."""
        return f"{self.prim.GetPath()}.{name}"

    def __iter__(self) -> Iterator[Snapshot]:
        """Yield the shape at every time, read on demand."""
        return (self.at(time) for time in self.times or [None])

    @cached_property
    def first(self) -> Snapshot:
        """Return the shape at its first time."""
        return self.at(self.times[0] if self.times else None)

    @cached_property
    def points(self) -> list[float]:
        """Return the codes at which the points have samples."""
        return self.prim.GetAttribute("points").GetTimeSamples()

    @cached_property
    def cuts(self) -> list[float]:
        """Return the time codes at which the shot is cut, from our notes."""
        cuts = notes_of(self.prim.GetStage()).get("cuts")
        return [float(cut) for cut in cuts] if cuts and isinstance(cuts, Vt.IntArray) else []

    def is_cut(self, before: Snapshot, after: Snapshot) -> bool:
        """Return whether the shot is cut between two times."""
        return any(before.time.GetValue() < cut <= after.time.GetValue() for cut in self.cuts)

    @property
    def moves(self) -> bool:
        """Return whether its points have samples at more than one time."""
        return len(self.points) > 1

    @cached_property
    def still(self) -> Snapshot | None:
        """Return hair in its rest pose; None where rest pose or hair is missing or invalid."""
        still = Still(self.prim, self.first.time)
        return still if still.sound and self.first.sound else None

    @cached_property
    def growth(self) -> np.ndarray:
        """Return the lengths of strands at rest over those at the first time, (c,); 1 where there is no rest."""
        if self.still is None:
            return np.ones(len(self.first.counts))
        return self.still.lengths / np.maximum(self.first.lengths, np.finfo(np.float64).tiny)

    @cached_property
    def reference(self) -> Snapshot | None:
        """Return hair in its own rest pose, else at its first time; None where it is invalid."""
        near = self.still is not None and REST[0] <= np.median(self.growth) <= REST[1]
        return self.still if near else self.first if self.first.sound else None


class Still(Snapshot):
    """Hair at rest."""

    @cached_property
    def points(self) -> np.ndarray:
        """Return rest positions, (n, 3) float32."""
        pref = self.array("primvars:pref", 3)
        return np.empty((0, 3), np.float32) if pref is None else pref


OURS = ("primvars:hairId", "primvars:pref", "primvars:skinprim", "velocities")
MANY = 20  # fewest curves that are hair


@dataclass(frozen=True)
class Scene:
    """Visible shapes of a stage.

    hair    curves of hair
    meshes  visible meshes
    skins   all meshes: the skin of hair may be invisible
    roots   roots of hair on them, by its path, as far as they were searched
    """

    stage: Usd.Stage
    hair: list[Track]
    meshes: list[Track]
    skins: list[Track]
    roots: dict[Sdf.Path, Any] = field(default_factory=dict)

    @cached_property
    def bindings(self) -> dict[Sdf.Path, Binding]:
        """Return the bindings of meshes to skeletons; none for invalid skeletons."""
        try:
            return find_bindings(self.stage)
        except BadInput:
            return {}

    @cached_property
    def metres(self) -> np.ndarray:
        """Return the matrix from the world to metres with Y up, column vectors, (4, 4) float64."""
        return to_metres(self.stage)

    def place(self, mesh: Track, time: float | None) -> np.ndarray:
        """Return the points of a mesh in the world, moved by its skeleton if it has one, (n, 3) float64."""
        shape = mesh.at(time)
        binding = self.bindings.get(mesh.prim.GetPath())
        if binding is None or not len(shape.points):
            return shape.placed
        points = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(shape.points))
        transforms = binding.skeleton.ComputeSkinningTransforms(shape.time)
        binding.skinning.ComputeSkinnedPoints(transforms, points, shape.time)
        skeleton = UsdGeom.Xformable(binding.skeleton.GetPrim()).ComputeLocalToWorldTransform(shape.time)
        return np.array(points) @ np.array(skeleton)[:3, :3] + np.array(skeleton)[3, :3]

    def moves(self, mesh: Track) -> bool:
        """Return whether a mesh moves."""
        above = [mesh.prim]
        while above[-1].GetParent().IsA(UsdGeom.Xformable):
            above.append(above[-1].GetParent())
        turned = any(UsdGeom.Xformable(prim).TransformMightBeTimeVarying() for prim in above)
        return mesh.moves or turned or mesh.prim.GetPath() in self.bindings


def find_scene(stage: Usd.Stage) -> Scene:
    """Find the hair and meshes of a stage that are visible at its first time."""
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    hair = [Track(prim) for prim in prims if prim.IsA(UsdGeom.BasisCurves) and _is_drawn(prim)]
    skins = [Track(prim) for prim in prims if prim.IsA(UsdGeom.Mesh)]
    meshes = [track for track in skins if _is_drawn(track.prim)]
    return Scene(stage, [track for track in hair if _is_hair(track)], meshes, skins)


def _is_drawn(prim: Usd.Prim) -> bool:
    image = UsdGeom.Imageable(prim)
    shown = image and image.ComputeVisibility(Usd.TimeCode.EarliestTime()) != UsdGeom.Tokens.invisible
    return bool(shown and image.ComputePurpose() in RENDERED)


def _is_hair(track: Track) -> bool:
    """Return whether curves are hair, not a wire or a rope: many curves, or curves with attributes of hair."""
    return len(track.first.counts) >= MANY or any(track.prim.GetAttribute(name).HasAuthoredValue() for name in OURS)
