"""Alembic files (.abc): animated meshes, and hair with the attributes of Unreal's groom specification, version 1.5.

Read of curves: positions and widths; of arbitrary parameters: groom_id, groom_guide, groom_group_id, groom_group_name,
groom_root_uv, groom_width, groom_color, and the rest shape `rest` of Houdini; others that are a number for each curve
are maps. The file states neither unit nor axis.

Written for Unreal, which takes points as they are, as centimetres in its left-handed axes, and reads the version from
the topmost object (AlembicHairTranslator.cpp); for Houdini, which shows all attributes, and deforms hair with `rest`;
and for Blender, which reads points and widths, and turns the vertical axis itself.

Source: Alembic for Grooms Specification, dev.epicgames.com
"""

import errno
import importlib
import os
import shutil
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe import __version__
from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at, sampled
from hairpipe.formats.groom_shot import GroomShot
from hairpipe.formats.polygons import Polygons, join_polygons, triangulate, warn_of_cage, warn_of_unused
from hairpipe.formats.polylines import Up, join_groups, join_maps, join_values, plain_curves
from hairpipe.plain_file import checked_size
from hairpipe.values import Mesh
from hairpipe.values.groom import DIAMETERS, Curves, labels_of

EXACT = 1e-6
"""Distance from a sample at which a time is the sample [s]."""


@contextmanager
def library_for(
    path: Path, what: str = "not a readable Alembic file", right: str = "a file in the format Ogawa"
) -> Iterator[Any]:
    """Import the library for a file; BadInput where it is missing, and for what it raises in this block."""
    try:
        library = importlib.import_module("alembic3d")
    except ImportError:
        needed = "pip install 'hairpipe[alembic]', which installs alembic3d"
        raise BadInput("Alembic files are read by a library that is not installed", where=path, right=needed) from None
    try:
        yield library
    except RuntimeError as error:
        raise BadInput(f"{what}: {str(error).splitlines()[0][:160]}", where=path, right=right) from None


def read(path: Path, group: str | None, instant: Instant | None = None) -> Polygons:
    """Read the visible meshes of a file, of a group or all, at an instant; for None at the first sample.

    group  path of an object, or a pattern of paths, to read with all below

    Raises BadInput where the library is missing, the file is damaged, or it has no such meshes.
    """
    checked_size(path, "an Alembic file")
    with library_for(path):
        meshes = recall(AlembicMeshes, path, group, 1.0 if instant is None else instant.fps)
        return meshes.shape(0) if instant is None else read_at(meshes, instant)


class AlembicMeshes:
    """Samples of the meshes of a file, see `animated_meshes.Samples`; time codes are frames of the shot."""

    def __init__(self, path: Path, group: str | None, fps: float) -> None:
        self.library, self.path, self.rate = importlib.import_module("alembic3d"), path, fps
        self.files = [path]
        shapes = below(self.library.Abc.IArchive(str(path)).getTop(), group is None, group or "")
        self.pieces = [piece for piece in map(self._piece, shapes) if piece is not None]
        if not self.pieces:
            right = "a visible polygon mesh or subdivision surface"
            raise BadInput(f"no mesh{'' if group is None else f' at or under {group}'}", where=path, right=right)
        groups = [times for piece in self.pieces for times in piece.times()]
        times = np.array(sorted(sampled(groups) or groups[0]))
        self.seconds = times[np.insert(np.diff(times) > EXACT, 0, True)]
        self.codes = self.seconds * fps
        self.own = [piece.has_velocities for piece in self.pieces]

    def _piece(self, item: Any) -> "MeshPiece | None":
        geometry = self.library.AbcGeom
        header = item.getHeader()
        kind = next((kind for kind in (geometry.IPolyMesh, geometry.ISubD) if kind.matches(header)), None)
        if kind is not None and not geometry.IsAncestorInvisible(item, self.library.Abc.ISampleSelector()):
            piece = MeshPiece(self.library, self.path, item, kind(item.getParent(), item.getName()).getSchema())
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


class MeshPiece:
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


def below(item: Any, is_chosen: bool, group: str) -> Iterator[Any]:
    """Yield an object and all below it, from the objects on whose path is that of a group or fits its pattern."""
    is_chosen = is_chosen or item.getFullName() == group or fnmatchcase(item.getFullName(), group)
    if is_chosen:
        yield item
    for index in range(item.getNumChildren()):
        yield from below(item.getChild(index), is_chosen, group)


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


NUMBERS = ("Int32", "Float", "Int16", "Char", "Uchar", "Double", "UInt32", "Int64", "Boolean")
VECTORS = ("V2f", "V2d", "V3f", "C3f", "C4f", "V3d", "N3f", "P3f", "V3i")
PREFIX = "groom_"
READ = ("id", "guide", "group_id", "group_name", "root_uv", "width", "color", "version_major", "version_minor")
"""Parameters that have a meaning, with the prefix or without it."""
KNOWN = {"rest", DIAMETERS, *READ, *(PREFIX + name for name in READ)}
THROUGH = ("kNoBasis", "kCatmullromBasis")
"""Bases of cubic curves whose points lie on the curve, or that have none."""


class Piece(NamedTuple):
    """Curves of one object.

    name    of the object
    points  placed in the world of the file, (p, 3) float64
    counts  points of each, (S,) int64
    values  values of its parameters, flat: a row for each curve, point or object; by name, those with a meaning without
            the prefix
    """

    name: str
    points: np.ndarray
    counts: np.ndarray
    values: dict[str, np.ndarray]

    def maps(self) -> dict[str, np.ndarray]:
        """Return the parameters without a meaning that are a finite number for each curve, (S,) float64 each."""
        others = {name: values for name, values in self.values.items() if name not in KNOWN}
        return {
            name: values
            for name, values in others.items()
            if values.shape == (len(self.counts),) and values.dtype.kind == "f" and np.isfinite(values).all()
        }

    def at_points(self, name: str, columns: int) -> np.ndarray | None:
        """Return a parameter at all points, (p, columns); None where there is none that fits."""
        rows = self.fitting(name, len(self.points))
        return None if rows is None else rows.reshape(len(self.points), -1)[:, :columns]

    def widths(self) -> np.ndarray | None:
        """Return diameters at all points, (p, 1), else widths; None without."""
        diameters = self.at_points(DIAMETERS, 1)
        return self.at_points("width", 1) if diameters is None else diameters

    def fitting(self, name: str, count: int | None = None) -> np.ndarray | None:
        """Return a parameter of all curves, (S, ...), or of all points, whichever count is asked for.

        That of a curve, by default, is that of its root where it is one of points.
        """
        count = len(self.counts) if count is None else count
        found = self.values.get(name)
        if found is None or not len(found):
            return None
        if len(found) == 1 or len(found) == count:
            return np.broadcast_to(found, (count, *found.shape[1:]))
        if len(found) == len(self.counts):
            return np.repeat(found, self.counts, axis=0)
        if len(found) == len(self.points):
            return found[np.cumsum(self.counts) - self.counts]
        return None


def read_alembic(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the strands of the curves of a file at its first sample; BadInput without any, and for closed ones."""
    checked_size(path, "an Alembic file")
    with library_for(path) as library:
        pieces = list(pieces_of(library, library.Abc.IArchive(str(path)).getTop(), np.eye(4), path))
    if not pieces:
        raise BadInput("there are no curves", where=path, right="at least one object of curves")
    counts = np.concatenate([piece.counts for piece in pieces])
    if not len(counts) or (counts < 1).any():
        raise BadInput("a curve has no points", where=path, right="2 or more")
    sizes, lengths = [len(piece.counts) for piece in pieces], [len(piece.points) for piece in pieces]
    rest = [piece.at_points("rest", 3) for piece in pieces]
    rested = [points is not None for points in rest]
    known = KNOWN if all(rested) or not any("rest" in piece.values for piece in pieces) else KNOWN - {"rest"}
    unread = sorted({name for piece in pieces for name in piece.values.keys() - piece.maps().keys()} - known)
    if unread:
        warnings.warn(f"{path}: parameters that are not read: {', '.join(unread)}", stacklevel=2)
    more = {
        "widths": join_values([p.widths() for p in pieces], lengths, np.nan),
        "colours": join_values([p.at_points("color", 3) for p in pieces], lengths, 0.0),
        "root_uv": join_values([p.fitting("root_uv") for p in pieces], sizes, 0.0),
        "guides": join_values([p.fitting("guide") for p in pieces], sizes, 0.0),
        "rest": join_values(rest, lengths, 0.0) if all(rested) else None,
    }
    widths, guides = more["widths"], more["guides"]
    more["widths"] = None if widths is None else np.nan_to_num(widths[:, 0], nan=float(np.nanmedian(widths)))
    more["guides"] = None if guides is None else guides != 0
    more |= {n: v.astype(np.float32) for n in ("colours", "root_uv") if (v := more[n]) is not None}
    points = np.concatenate([piece.points for piece in pieces])
    found = plain_curves(points, counts, unit, up, maps=join_maps([p.maps() for p in pieces], sizes), **more)
    ids = join_values([piece.fitting("id") for piece in pieces], sizes, -1.0)
    if ids is not None and len(np.unique(ids)) == len(ids):
        found = replace(found, ids=ids.astype(np.int32))
    elif ids is not None:
        warnings.warn(f"{path}: groom_id repeats ids: strands are numbered by their order", stacklevel=2)
    groups, names = join_groups([labels_in(piece) for piece in pieces], sizes, [piece.name for piece in pieces])
    return found if groups is None else replace(found, groups=groups, group_names=names)


def labels_in(piece: Piece) -> np.ndarray | None:
    """Return the labels of the groups of the curves of an object, (S,) text; None without groups."""
    for name in ("group_name", "group_id"):
        values = piece.fitting(name)
        if values is not None:
            return values.astype(str) if name == "group_name" else values.astype(np.int64).astype(str)
    return None


def pieces_of(library: Any, item: Any, matrix: np.ndarray, path: Path) -> Iterator[Piece]:
    """Yield the curves of an object and of all below it; the matrix (4, 4) places row vectors in the world."""
    geometry = library.AbcGeom
    for index in range(item.getNumChildren()):
        child = item.getChild(index)
        header = child.getHeader()
        here = matrix
        if geometry.IXform.matches(header):
            own = geometry.IXform(item, child.getName()).getSchema().getValue()
            here = np.array(own.getMatrix(), np.float64).reshape(4, 4) @ matrix
        elif geometry.ICurves.matches(header):
            where = f"{path} {child.getFullName()}"
            schema = geometry.ICurves(item, child.getName()).getSchema()
            yield piece_of(library, child.getName(), schema, matrix, where)
        yield from pieces_of(library, child, here, path)


def piece_of(library: Any, name: str, schema: Any, matrix: np.ndarray, where: str) -> Piece:
    if schema.getNumSamples() > 1:
        warnings.warn(f"{where}: the first of {schema.getNumSamples()} samples is read", stacklevel=3)
    value = schema.getValue()
    points = np.array(value.getPositions(), np.float64).reshape(-1, 3)
    counts = np.array(value.getCurvesNumVertices(), np.int64)
    if counts.sum() != len(points) or (counts < 0).any():
        raise BadInput(f"numbers of points sum to {counts.sum()}", where=where, right=f"{len(points)}")
    if str(value.getWrap()).endswith("kPeriodic"):
        raise BadInput("the curves are closed", where=where, right="curves that are not periodic")
    basis = str(value.getBasis()).rpartition(".")[2]
    if str(value.getType()).endswith("kCubic") and basis not in THROUGH:
        warnings.warn(f"{where}: control points of the basis {basis} are read as points of hair", stacklevel=3)
    values = {"width": schema.getWidthsParam()} if schema.getWidthsParam().valid() else {}
    found = {key: np.array(param.getExpandedValue().getVals(), np.float64) for key, param in values.items()}
    parameters = schema.getArbGeomParams()
    for index in range(parameters.getNumProperties() if parameters.valid() else 0):
        header = parameters.getPropertyHeader(index)
        read = parameter(library, parameters, header)
        key = header.getName().removeprefix(PREFIX)
        found[key if key in READ else header.getName()] = np.empty(0) if read is None else read
    if "rest" in found and found["rest"].shape == points.shape:
        found["rest"] = found["rest"] @ matrix[:3, :3] + matrix[3, :3]
    return Piece(name, points @ matrix[:3, :3] + matrix[3, :3], counts, found)


def parameter(library: Any, parent: Any, header: Any) -> np.ndarray | None:
    """Return the values of a parameter, (n,) or (n, k); text as text; None for another type."""
    for kind in (*NUMBERS, *VECTORS, "String"):
        reader = getattr(library.AbcGeom, f"I{kind}GeomParam")
        if reader.matches(header):
            values = reader(parent, header.getName()).getExpandedValue().getVals()
            if kind == "String":
                return np.array([str(text) for text in values], str)
            return np.array(values, np.float64)
    return None


VERSION = (1, 5)
GUIDED = ("groom_closest_guides", "groom_guide_weights")
"""Parameters of the guides of each strand, and of their weights; Unreal reads them, we do not."""
LEFT_HANDED_Z_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])


class Target(NamedTuple):
    """What a program reads.

    metres  unit of its lengths [m]
    axes    its coordinates from ours, (3, 3)
    rest    whether it reads the rest shape
    apart   whether guides are an object of their own
    """

    metres: float
    axes: np.ndarray
    rest: bool
    apart: bool

    def placed(self, vectors: np.ndarray) -> np.ndarray:
        """Return points or velocities, (p, 3), in the units and axes of the program."""
        return vectors @ self.axes.T / self.metres


TARGETS = {
    "unreal": Target(0.01, LEFT_HANDED_Z_UP, rest=False, apart=False),
    "houdini": Target(1.0, np.eye(3), rest=True, apart=True),
    "blender": Target(1.0, np.eye(3), rest=False, apart=True),
}


def write_alembic(path: Path, shot: GroomShot, name: str) -> None:
    """Write hair and guides for a program, with samples at the true times of frames."""
    target = TARGETS[name]
    if shutil.disk_usage(path.parent).free < size_of(shot):  # the library ends the process where the disk is full
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    frames = [] if shot.hair is None else list(shot.hair)
    right = "a folder with space, where files can be made"
    with library_for(path, "the Alembic file was not written", right) as library:
        archive = library.Abc.OArchive(str(path))
        times = archive.addTimeSampling(sampling_of(library, np.array(frames or [0]) / shot.fps, shot.fps))
        top = library.AbcGeom.OXform(archive.getTop(), "groom")
        properties = top.getSchema().getUserProperties()
        for word, number in zip(("groom_version_major", "groom_version_minor"), VERSION, strict=True):
            library.Abc.OInt16Property(properties, word).setValue(number)
        library.Abc.OStringProperty(properties, "groom_tool").setValue(f"hairpipe {__version__}")
        maps = shot.maps({*KNOWN, *(GUIDED if shot.closest else ())})
        pieces = shot.pieces(target.apart).items()
        written = [CurvesWriter(library, top, piece, shot, maps, target, times) for piece in pieces]
        for curves in written if not frames else ():
            curves.add(shot.groom.points, None, shot.widths(None))
        for frame in frames:
            hair = shot.at(frame)
            widths = shot.widths(hair)
            for curves in written:
                curves.add(hair.points, hair.velocities, widths)


def size_of(shot: GroomShot) -> int:
    """Return an upper bound of the bytes of a file: points, velocities and widths, and what does not move."""
    points, strands, maps = len(shot.groom.points), len(shot.groom.ids), len(shot.groom.maps)
    moving = 28 * points * (1 + len(shot.hair or ()))
    return 100_000 + moving + 32 * points + (256 + 4 * maps) * strands + 1_000 * maps


def sampling_of(library: Any, seconds: np.ndarray, fps: float) -> Any:
    """Return the times of samples: uniform where frames follow each other at equal distances, since Unreal asks so."""
    core = library.AbcCoreAbstract
    steps = np.diff(seconds)
    if not len(steps) or np.ptp(steps) * fps < 1e-6:
        return core.TimeSampling(steps[0] if len(steps) else 1 / fps, seconds[0])
    times = core.TimeVector()
    times.extend(seconds.tolist())
    return core.TimeSampling(core.TimeSamplingType(core.AcyclicFlag.kAcyclic), times)


class CurvesWriter:
    """Curves of one object in a file that is open for writing."""

    def __init__(
        self,
        library: Any,
        top: Any,
        piece: tuple[str, np.ndarray],
        shot: GroomShot,
        maps: dict[str, np.ndarray],
        target: Target,
        times: int,
    ) -> None:
        name, self.strands = piece
        self.library, self.target = library, target
        self.vertex = library.AbcGeom.GeometryScope.kVertexScope
        self.rows = shot.rows(self.strands)
        space = library.AbcGeom.OXform(top, name)  # Blender names objects by the transforms above them
        self.schema = library.AbcGeom.OCurves(space, name, times).getSchema()
        self.counts = array("IntArray", np.diff(shot.groom.offsets)[self.strands])
        self._author(shot, maps)

    def add(self, points: np.ndarray, velocities: np.ndarray | None, widths: np.ndarray) -> None:
        """Write points [m] and velocities [m/s], (P, 3) each, and widths, (P,) [m], at the next sample."""
        geometry = self.library.AbcGeom
        sample = geometry.OCurvesSchemaSample(self._vectors(points), self.counts, geometry.CurveType.kLinear)
        sample.setBasis(geometry.BasisType.kNoBasis)  # by default Bezier, which Blender draws also for linear curves
        wide = array("FloatArray", widths[self.rows] / self.target.metres)
        sample.setWidths(geometry.OFloatGeomParamSample(wide, self.vertex))
        if velocities is not None:
            sample.setVelocities(self._vectors(velocities))
        self.schema.set(sample)

    def _vectors(self, vectors: np.ndarray) -> Any:
        return array("V3fArray", self.target.placed(vectors[self.rows]))

    def _author(self, shot: GroomShot, maps: dict[str, np.ndarray]) -> None:
        uniform = self.library.AbcGeom.GeometryScope.kUniformScope
        groom, strands = shot.groom, self.strands
        numbers = {"groom_id": groom.ids, "groom_guide": groom.guides, "groom_group_id": groom.groups}
        for name, values in numbers.items():
            if values is not None:
                self._parameter("Int32", name, array("IntArray", values[strands]), uniform)
        for name, values in maps.items():
            self._parameter("Float", name, array("FloatArray", values[strands]), uniform)
        if groom.groups is not None and groom.group_names:
            names = labels_of(groom.groups, groom.group_names)[strands]
            self._parameter("String", "groom_group_name", texts(names.tolist()), uniform)
        self._parameter("V2f", "groom_root_uv", array("V2fArray", groom.root_uv[strands]), uniform)
        if shot.closest is not None:
            closest, weights = (values[strands] for values in shot.closest)
            self._parameter("V3i", GUIDED[0], array("V3iArray", closest), uniform)
            self._parameter("V3f", GUIDED[1], array("V3fArray", weights), uniform)
        if groom.colours is not None:
            self._parameter("V3f", "groom_color", array("V3fArray", groom.colours[self.rows]), self.vertex)
        if shot.hairs is not None:
            diameters = array("FloatArray", shot.diameters(shot.first())[self.rows] / self.target.metres)
            self._parameter("Float", DIAMETERS, diameters, self.vertex)
        if self.target.rest:
            self._parameter("V3f", "rest", self._vectors(groom.points), self.vertex)

    def _parameter(self, kind: str, name: str, values: Any, scope: Any) -> None:
        geometry = self.library.AbcGeom
        made = getattr(geometry, f"O{kind}GeomParam")(self.schema.getArbGeomParams(), name, False, scope, 1)
        made.set(getattr(geometry, f"O{kind}GeomParamSample")(values, scope))


def array(kind: str, values: np.ndarray) -> Any:
    import imath

    made = getattr(imath, kind)(len(values))
    np.asarray(made)[:] = values
    return made


def texts(values: list[str]) -> Any:
    import imath

    made = imath.StringArray(len(values))
    for index, value in enumerate(values):
        made[index] = value
    return made
