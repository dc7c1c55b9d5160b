"""Curves of a stage as polylines in metres."""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import UsdGeom

from hairpipe.data.curves import Curves, numbered
from hairpipe.errors import BadInput
from hairpipe.io.usd.groom.attributes import (
    colours,
    groups,
    guides,
    maps,
    own_ids,
    rest_points,
    root_uv,
    strand_ids,
    unused_primvars,
    widths,
)
from hairpipe.io.usd.groom.splines import Nurbs, polyline
from hairpipe.io.usd.stage import (
    go_to,
    location,
    move,
    numbers,
    open_whole,
    place,
    read_time,
    shaped,
    shown,
    time_of,
    usd_faults,
)
from hairpipe.plain_file import Absent

NAMED = 5  # number of curves in a message


def read(
    path: Path, prim: str | None, time: float | None = None, guides: bool = False, absent: Absent = "refuse"
) -> Curves:
    """Read the visible curves at or under a prim; see `hairpipe.io.usd.read.read_curves`."""
    with usd_faults(path):
        stage = open_whole(path, prim, absent)
        go_to(stage, time)
        kinds = (UsdGeom.BasisCurves, UsdGeom.NurbsCurves)
        found = shown(stage, prim, *kinds, guides="also" if guides else "only")
        prims = [(UsdGeom.NurbsCurves if p.IsA(UsdGeom.NurbsCurves) else UsdGeom.BasisCurves)(p) for p in found]
        parts = [_read_part(curves) for curves in prims]
        time = read_time([curves.GetPrim() for curves in prims], time)
        pairs = zip(prims, parts, strict=True)
        unused = sorted({name for curves, part in pairs for name in unused_primvars(curves, part.maps)})
    if unused:
        warnings.warn(f"{path}: primvars that are not used: {', '.join(unused)}", stacklevel=2)
    lines = [line for part in parts for line in part.lines]
    if not lines:
        raise BadInput("the curves have no points", where=path, right="at least one curve")
    columns = np.concatenate(lines)
    offsets = np.cumsum([0] + [len(line) for line in lines]).astype(np.int32)
    return Curves(
        np.ascontiguousarray(columns[:, :3]),
        offsets,
        own_ids(np.concatenate([part.ids for part in parts]), path),
        np.zeros(len(lines), bool),
        np.concatenate([part.spare for part in parts]),
        np.ascontiguousarray(columns[:, 3:6]) if any(part.rested for part in parts) else None,
        _known_widths(columns[:, 6], offsets, path),
        time,
        _joined([part.uv for part in parts], parts, 0.0),
        *_joined_groups(parts, [curves.GetPrim().GetName() for curves in prims]),
        _joined([part.guides for part in parts], parts, False),
        np.nan_to_num(columns[:, 7:]).astype(np.float32) if any(part.coloured for part in parts) else None,
        _joined_maps(parts),
    )


def _joined(values: Sequence[np.ndarray | None], parts: list["_Part"], blank: object) -> np.ndarray | None:
    """Return values of the strands of all parts, (S, ...), with a blank in parts without them; None without any."""
    given = next((found for found in values if found is not None), None)
    if given is None:
        return None
    pairs = zip(values, parts, strict=True)
    shapes = ((found, (len(part.ids), *given.shape[1:])) for found, part in pairs)
    return np.concatenate([np.full(shape, blank, given.dtype) if found is None else found for found, shape in shapes])


def _joined_maps(parts: list["_Part"]) -> dict[str, np.ndarray]:
    """Return the maps of the strands of all parts, (S,) each: 0 in parts without them."""
    names = sorted({name for part in parts for name in part.maps})
    return {n: np.concatenate([part.maps.get(n, np.zeros(len(part.ids))) for part in parts]) for n in names}


def _joined_groups(parts: list["_Part"], names: list[str]) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Return the group of each strand, (S,) int32, and their names; of several prims without groups each is one."""
    labels = [part.groups for part in parts]
    if all(groups is None for groups in labels) and len(parts) == 1:
        return None, ()
    pairs = zip(labels, parts, names, strict=True)
    return numbered(np.concatenate([np.full(len(p.ids), n) if found is None else found for found, p, n in pairs]))


class _Part(NamedTuple):
    """The curves of one prim.

    lines     points of each with rest shape, width and colour, (n, 10) float64; NaN without a width or colour
    spare     number of points beyond either end of each, (S,) int64
    ids       ids of the prim, (S,) int64, or NONE
    rested    whether the prim has a rest shape
    coloured  whether it has colours
    uv        texture coordinates of the roots, (S, 2)
    groups    group of each strand as text, (S,)
    guides    whether each strand is a guide, (S,)
    maps      values of each strand by the names of their primvars, (S,) each
    """

    lines: list[np.ndarray]
    spare: np.ndarray
    ids: np.ndarray
    rested: bool
    coloured: bool
    uv: np.ndarray | None
    groups: np.ndarray | None
    guides: np.ndarray | None
    maps: dict[str, np.ndarray]


def _read_part(curves: UsdGeom.Curves) -> _Part:
    attribute = curves.GetPointsAttr()
    points = shaped(attribute.Get(time_of(curves.GetPrim())), attribute, 3)
    counts = numbers(curves.GetCurveVertexCountsAttr(), kind=np.int64)
    where = location(curves.GetPrim())
    if counts.sum() != len(points) or (counts < 0).any():
        right = f"the number of points, {len(points)}"
        raise BadInput(f"curveVertexCounts sum to {counts.sum()}", where=where, right=right)
    matrix = place(curves.GetPrim())
    rest = rest_points(curves, len(points))
    columns = np.column_stack([move(matrix, points), move(matrix, points if rest is None else rest)])
    strands = np.split(columns, np.cumsum(counts)[:-1]) if len(counts) else []
    scale = np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
    thick = widths(curves, counts)
    tint = colours(curves, counts)
    given = [[w[:, None] * scale, np.full((1, 3), np.nan) if tint is None else tint[i]] for i, w in enumerate(thick)]
    nurbs = Nurbs(curves, counts, where) if isinstance(curves, UsdGeom.NurbsCurves) else None
    lines = list[np.ndarray]()
    spare = list[int]()
    faults = dict[int, BadInput]()
    for i, strand in enumerate(strands):
        values = [_at_points(held, len(strand)) for held in given[i]]
        place_of = f"{where} curve {i}"
        try:
            whole = np.column_stack([strand, *values])
            line, beyond = (
                polyline(curves, whole, place_of) if nurbs is None else (nurbs.polyline(i, whole, place_of), 0)
            )
        except BadInput as fault:
            faults[i] = fault
            continue
        for column, held in zip((slice(6, 7), slice(7, 10)), given[i], strict=True):
            if len(held) != len(strand):
                line[:, column] = _between(held, len(line), beyond)
        lines.append(line)
        spare.append(beyond)
    _report(faults, len(strands), where)
    kept = np.delete(np.arange(len(strands)), list(faults))
    marks = (root_uv(curves, counts), groups(curves, len(counts)), guides(curves, len(counts)))
    marks = (None if mark is None else mark[kept] for mark in marks)
    ids = strand_ids(curves, len(counts))[kept]
    painted = {name: values[kept] for name, values in maps(curves, len(counts)).items()}
    return _Part(lines, np.array(spare, np.int64), ids, rest is not None, tint is not None, *marks, painted)


def _report(faults: dict[int, BadInput], total: int, where: str) -> None:
    """Warn of omitted curves, by their indices; raise the first fault where no curve is left."""
    if faults and len(faults) == total:
        raise next(iter(faults.values()))
    if faults:
        named = ", ".join(map(str, list(faults)[:NAMED])) + (f" and {len(faults) - NAMED} more" * (len(faults) > NAMED))
        why = next(iter(faults.values())).what
        warnings.warn(f"{where}: {len(faults)} of {total} curves are left out: {named}: {why}", stacklevel=3)


def _at_points(values: np.ndarray, count: int) -> np.ndarray:
    """Return values, (n, k), at `count` points, (count, k); unknown ones are interpolated.

    All are NaN where none is known, or where their number does not match.
    """
    known = np.isfinite(values).all(axis=1)
    if len(values) != count or not known.any():
        return np.full((count, values.shape[1]), np.nan)
    places = np.flatnonzero(known)
    return np.stack([np.interp(np.arange(count), places, column[known]) for column in values.T], axis=1)


def _between(values: np.ndarray, rows: int, beyond: int) -> np.ndarray:
    """Return values at the points of a line, (rows, k), from those at the ends of its spans, (n, k), at equal steps.

    beyond  points of the line before the curve begins
    """
    ends = np.linspace(beyond, rows - 1 - beyond, len(values))
    filled = _at_points(values, len(values))
    return np.stack([np.interp(np.arange(rows), ends, column) for column in filled.T], axis=1)


def _known_widths(widths: np.ndarray, offsets: np.ndarray, path: Path) -> np.ndarray | None:
    """Return the widths of all lines, (p,); their median where a line has none; None where no line has any."""
    known = ~np.isnan(widths)
    if not known.any():
        return None
    if not known.all():
        bare = (~np.logical_and.reduceat(known, offsets[:-1])).sum()
        message = f"{bare} of {len(offsets) - 1} curves have no valid widths, and get the median of the others"
        warnings.warn(f"{path}: {message}", stacklevel=3)
    return np.where(known, widths, np.median(widths[known]))
