"""Strands of Alembic files (.abc): curves with the attributes of Unreal's groom specification, version 1.5.

Of curves: positions and widths; of arbitrary parameters: groom_id, groom_guide, groom_group_id, groom_group_name,
groom_root_uv, groom_width, groom_color, and the rest shape `rest` of Houdini; others that are a number for each curve
are maps. The file states neither unit nor axis.

Source: Alembic for Grooms Specification, dev.epicgames.com
"""

import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.alembic_meshes import import_alembic
from hairpipe.formats.polylines import Up, join_groups, join_maps, join_values, plain_curves
from hairpipe.plain_file import checked_size
from hairpipe.values.groom import DIAMETERS, Curves

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

    def at_strands(self, name: str) -> np.ndarray | None:
        """Return a parameter of all curves, (S, ...); that of the root where it is one of points."""
        return self.fitting(name, len(self.counts))

    def fitting(self, name: str, count: int) -> np.ndarray | None:
        """Return a parameter for all curves, or for all points, whichever count is asked for."""
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
    library = import_alembic(path)
    try:
        archive = library.Abc.IArchive(str(path))
        pieces = list(pieces_of(library, archive.getTop(), np.eye(4), path))
    except RuntimeError as error:
        what = f"not a readable Alembic file: {str(error).splitlines()[0][:160]}"
        raise BadInput(what, where=path, right="a file in the format Ogawa") from None
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
        "widths": join_values([widths_in(p) for p in pieces], lengths, np.nan),
        "colours": join_values([p.at_points("color", 3) for p in pieces], lengths, 0.0),
        "root_uv": join_values([p.at_strands("root_uv") for p in pieces], sizes, 0.0),
        "guides": join_values([p.at_strands("guide") for p in pieces], sizes, 0.0),
        "rest": join_values(rest, lengths, 0.0) if all(rested) else None,
    }
    widths, guides = more["widths"], more["guides"]
    more["widths"] = None if widths is None else np.nan_to_num(widths[:, 0], nan=float(np.nanmedian(widths)))
    more["guides"] = None if guides is None else guides != 0
    more |= {n: v.astype(np.float32) for n in ("colours", "root_uv") if (v := more[n]) is not None}
    points = np.concatenate([piece.points for piece in pieces])
    found = plain_curves(points, counts, unit, up, maps=join_maps([p.maps() for p in pieces], sizes), **more)
    ids = join_values([piece.at_strands("id") for piece in pieces], sizes, -1.0)
    if ids is not None and len(np.unique(ids)) == len(ids):
        found = replace(found, ids=ids.astype(np.int32))
    elif ids is not None:
        warnings.warn(f"{path}: groom_id repeats ids: strands are numbered by their order", stacklevel=2)
    labels = [labels_in(piece) for piece in pieces]
    groups, names = join_groups(labels, sizes, [piece.name for piece in pieces])
    return found if groups is None else replace(found, groups=groups, group_names=names)


def widths_in(piece: Piece) -> np.ndarray | None:
    """Return the diameters of the curves of an object at all points, (p, 1), else their widths; None without."""
    diameters = piece.at_points(DIAMETERS, 1)
    return piece.at_points("width", 1) if diameters is None else diameters


def labels_in(piece: Piece) -> np.ndarray | None:
    """Return the labels of the groups of the curves of an object, (S,) text; None without groups."""
    for name in ("group_name", "group_id"):
        values = piece.at_strands(name)
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
