"""A shape at one time as arrays, read once and checked by many rules."""

from functools import cached_property

import numpy as np
from pxr import Usd, UsdGeom

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
