"""Animated meshes of Alembic files (.abc): polygons and subdivision surfaces, in the units and axes of the file."""

import importlib
import warnings
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at, sampled
from hairpipe.formats.polygons import Polygons, join_polygons, triangulate, warn_of_cage, warn_of_unused
from hairpipe.plain_file import checked_size
from hairpipe.values import Mesh

EXACT = 1e-6
"""Distance from a sample at which a time is the sample [s]."""


def read(path: Path, group: str | None, instant: Instant | None) -> Polygons:
    """Read the visible meshes of a file, of a group or all, at an instant; for None at the first sample.

    group  path of an object, or a pattern of paths, to read with all below

    Raises BadInput where the library is missing, the file is damaged, or it has no such meshes.
    """
    checked_size(path, "an Alembic file")
    import_alembic(path)
    try:
        meshes = recall(AlembicMeshes, path, group, 1.0 if instant is None else instant.fps)
        return meshes.shape(0) if instant is None else read_at(meshes, instant)
    except RuntimeError as error:
        what = f"not a readable Alembic file: {str(error).splitlines()[0][:160]}"
        raise BadInput(what, where=path, right="a file in the format Ogawa") from None


def read_rest(path: Path, group: str | None) -> Polygons:
    """Read the visible meshes of a file at the first sample; see `read`."""
    return read(path, group, None)


def import_alembic(path: Path) -> Any:
    """Import the library for a file; BadInput where it is missing."""
    try:
        return importlib.import_module("alembic3d")
    except ImportError:
        right = "pip install 'hairpipe[alembic]', which installs alembic3d"
        raise BadInput("Alembic files are read by a library that is not installed", where=path, right=right) from None


class AlembicMeshes:
    """Samples of the meshes of a file, see `animated_meshes.Samples`; time codes are frames of the shot.

    Raises BadInput where there are no meshes; warns of other shapes.
    """

    def __init__(self, path: Path, group: str | None, fps: float) -> None:
        self.library, self.path, self.rate = import_alembic(path), path, fps
        self.files = [path]
        archive = self.library.Abc.IArchive(str(path))
        shapes = [item for item in below(archive.getTop()) if _fits(item.getFullName(), group)]
        self.pieces = [piece for piece in map(self._piece, shapes) if piece is not None]
        if not self.pieces:
            right = "a visible polygon mesh or subdivision surface"
            raise BadInput(f"no mesh{'' if group is None else f' at or under {group}'}", where=path, right=right)
        groups = [times for piece in self.pieces for times in piece.times()]
        times = np.array(sorted(sampled(groups) or groups[0]))
        self.seconds = times[np.insert(np.diff(times) > EXACT, 0, True)]
        self.codes = self.seconds * fps
        self.own = [piece.has_velocities for piece in self.pieces]

    def _piece(self, item: Any) -> "Piece | None":
        geometry = self.library.AbcGeom
        header = item.getHeader()
        kind = next((kind for kind in (geometry.IPolyMesh, geometry.ISubD) if kind.matches(header)), None)
        if kind is not None and not geometry.IsAncestorInvisible(item, self.library.Abc.ISampleSelector()):
            piece = Piece(self.library, self.path, item, kind(item.getParent(), item.getName()).getSchema())
            if kind is geometry.ISubD:
                piece.warn_of_cage()
            return piece
        if kind is not None or any(k.matches(header) for k in (geometry.ICurves, geometry.INuPatch, geometry.IPoints)):
            why = "which is invisible" if kind else "which is not a mesh"
            warnings.warn(f"{self.path} {item.getFullName()}, {why}, is not read", stacklevel=2)
        return None

    def shape(self, sample: int) -> Polygons:
        return join_polygons([piece.shape(self.seconds[sample]) for piece in self.pieces])

    def sample(self, sample: int) -> list[Points]:
        return [piece.sample(self.seconds[sample]) for piece in self.pieces]


class Piece:
    """Samples of one mesh, with the transforms above it."""

    def __init__(self, library: Any, path: Path, item: Any, schema: Any) -> None:
        self.library, self.schema = library, schema
        self.where = f"{path} {item.getFullName()}"
        self.spaces = list(self._spaces(item.getParent()))
        moves = any(space.getNumSamples() > 1 for space in self.spaces)
        velocities = schema.getVelocitiesProperty() if hasattr(schema, "getVelocitiesProperty") else None
        self.has_velocities = bool(velocities and velocities.valid()) and not moves
        self.polygons = self._polygons(0)
        self.changes = str(schema.getTopologyVariance()).endswith("kHeterogenousTopology")

    def warn_of_cage(self) -> None:
        """Warn where the first sample, of a subdivision surface, is not near that surface."""
        sizes, corners = self.polygons
        points = self._points(0)[0]
        if len(corners) and sizes.sum() == len(corners) and 0 <= corners.min() <= corners.max() < len(points):
            warn_of_cage(self.where, points, sizes, corners, "catmullClark")

    def times(self) -> list[list[float]]:
        """Return the times of all samples of points and transforms [s]."""
        return [times_of(schema).tolist() for schema in (self.schema, *self.spaces)]

    def shape(self, time: float) -> Polygons:
        """Read the triangles and points at a time; BadInput where counts, indices and points do not agree."""
        sizes, corners = self.polygons
        points = self.sample(time)[0]
        if len(sizes) == 0 or sizes.min() < 3 or sizes.sum() != len(corners) or not len(points):
            what = "counts and indices of the polygons do not agree"
            raise BadInput(what, where=self.where, right="3 corners or more")
        if corners.min() < 0 or corners.max() >= len(points):
            what = "a polygon names a point that does not exist"
            raise BadInput(what, where=self.where, right=f"0 to {len(points) - 1}")
        others = self.schema.getArbGeomParams()
        count = others.getNumProperties() if others.valid() else 0
        warn_of_unused(self.where, [others.getPropertyHeader(index).getName() for index in range(count)])
        chosen = triangulate(points[corners], sizes)[:, ::-1]  # Alembic winds polygons clockwise
        uv = self._coordinates(len(points))
        mesh = Mesh(points, np.ascontiguousarray(corners[chosen], np.int32), uv=None if uv is None else uv[chosen])
        return Polygons(mesh, np.repeat(np.arange(len(sizes)), sizes - 2))

    def sample(self, time: float) -> Points:
        """Read points and velocities at a time, linear between samples; BadInput where polygons have changed."""
        before, after, share = around(times_of(self.schema), time)
        if self.changes and not all(map(np.array_equal, self._polygons(before), self.polygons)):
            where = f"{self.where}, sample {before}"
            raise BadInput("the polygons have changed", where=where, right="those of the first sample at all times")
        pairs = [self._points(before), self._points(after) if share else None]
        matrix = self._matrix(time)
        points, velocities = (
            None if a is None else a if b is None else (1.0 - share) * a + share * b
            for a, b in zip(pairs[0] or (), pairs[1] or (None, None), strict=True)
        )
        if points is None or not np.isfinite(points).all():
            raise BadInput("points are not all finite", where=f"{self.where}, sample {before}", right="finite numbers")
        moved = points @ matrix[:3, :3] + matrix[3, :3]
        return moved, velocities @ matrix[:3, :3] if velocities is not None else None

    def _at(self, schema: Any, sample: int) -> Any:
        """Return the selector of a sample: the library takes a number for a time, also a whole one."""
        return self.library.Abc.ISampleSelector(float(schema.getTimeSampling().getSampleTime(sample)))

    def _points(self, sample: int) -> Points:
        value = self.schema.getValue(self._at(self.schema, sample))
        points = np.array(value.getPositions(), np.float64).reshape(-1, 3)
        velocities = value.getVelocities() if self.has_velocities else None
        if velocities is None:
            return points, None
        if len(velocities) != len(points):
            what = f"there are {len(velocities)} velocities"
            raise BadInput(what, where=f"{self.where}, sample {sample}", right=f"{len(points)}")
        return points, np.array(velocities, np.float64)

    def _polygons(self, sample: int) -> tuple[np.ndarray, np.ndarray]:
        value = self.schema.getValue(self._at(self.schema, sample))
        return np.array(value.getFaceCounts(), np.int64), np.array(value.getFaceIndices(), np.int64)

    def _coordinates(self, count: int) -> np.ndarray | None:
        """Return the texture coordinates of the corners of polygons, (c, 2) float32, None without any."""
        parameter = self.schema.getUVsParam()
        if not parameter.valid():
            return None
        values = np.array(parameter.getExpandedValue(self._at(parameter, 0)).getVals(), np.float32)
        _, corners = self.polygons
        if len(values) == len(corners):
            return values
        if len(values) == count:
            return values[corners]
        what = f"there are {len(values)} texture coordinates for {len(corners)} corners of {count} points"
        warnings.warn(f"{self.where}: {what}: the mesh is read without them", stacklevel=2)
        return None

    def _spaces(self, item: Any) -> Iterator[Any]:
        """Yield the transforms above a mesh, from the inner one."""
        geometry = self.library.AbcGeom
        while item.valid() and item.getFullName() != "/":
            if geometry.IXform.matches(item.getHeader()):
                yield geometry.IXform(item.getParent(), item.getName()).getSchema()
            item = item.getParent()

    def _matrix(self, time: float) -> np.ndarray:
        """Return the matrix of all transforms at a time, row vectors, (4, 4), linear between samples."""
        matrix = np.eye(4)
        for space in self.spaces:
            before, after, share = around(times_of(space), time)
            values = [space.getValue(self._at(space, sample)) for sample in (before, after)]
            first, second = (np.array(value.getMatrix(), np.float64) for value in values)
            matrix = matrix @ ((1.0 - share) * first + share * second)
            if not values[0].getInheritsXforms():
                break
        return matrix


def below(item: Any) -> Iterator[Any]:
    yield item
    for index in range(item.getNumChildren()):
        yield from below(item.getChild(index))


def times_of(schema: Any) -> np.ndarray:
    """Return the times of the samples of a schema, (n,) [s]; 0 for a constant one without any."""
    sampling = schema.getTimeSampling()
    count = max(schema.getNumSamples(), 1)
    return np.array([sampling.getSampleTime(k) for k in range(count)])


def around(times: np.ndarray, at: float) -> tuple[int, int, float]:
    """Return the samples before and after a time, and its share of the way; the same two at a sample and outside."""
    after = int(np.searchsorted(times, at - EXACT))
    if after == len(times) or times[after] <= at + EXACT or after == 0:
        nearest = min(after, len(times) - 1)
        return nearest, nearest, 0.0
    return after - 1, after, float((at - times[after - 1]) / (times[after] - times[after - 1]))


def _fits(name: str, group: str | None) -> bool:
    """Return whether a path, or one above it, is that of a group or fits its pattern."""
    parts = name.split("/")
    paths = ["/".join(parts[: k + 1]) for k in range(1, len(parts))]
    return group is None or any(path == group or fnmatchcase(path, group) for path in paths)
