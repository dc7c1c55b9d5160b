"""Curves of a stage as polylines in metres."""

import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import UsdGeom

from hairpipe.data.curves import Curves
from hairpipe.errors import BadInput
from hairpipe.io.usd.attributes import own_ids, rest_points, strand_ids, unused_primvars, widths
from hairpipe.io.usd.stage import (
    location,
    move,
    numbers,
    open_alone,
    place,
    read_time,
    shaped,
    shown,
    time_of,
    usd_faults,
)

STEPS = 8  # chords per span of an approximating cubic: an error of 1/64 of its sagitta
NAMED = 5  # number of curves in a message
BEYOND = {UsdGeom.Tokens.catmullRom: 1, UsdGeom.Tokens.bspline: STEPS}
"""Number of points at either end that a curve without pins does not reach."""
BSPLINE = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
BEZIER = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1.0]])


def read(path: Path, prim: str | None, time: float | None = None) -> Curves:
    """Read the visible curves at or under a prim; see `hairpipe.io.usd.read.read_curves`."""
    with usd_faults(path):
        stage = open_alone(path, time)
        prims = [UsdGeom.BasisCurves(p) for p in shown(stage, UsdGeom.BasisCurves, prim, guides=True)]
        parts = [_read_part(curves) for curves in prims]
        time = read_time([curves.GetPrim() for curves in prims], time)
        unused = sorted({name for curves in prims for name in unused_primvars(curves)})
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
    )


class _Part(NamedTuple):
    """The curves of one prim.

    lines   points of each with rest shape and width, (n, 7) float64; NaN without a width
    spare   number of points beyond either end of each, (S,) int64
    ids     ids of the prim, (S,) int64, or NONE
    rested  whether the prim has a rest shape
    """

    lines: list[np.ndarray]
    spare: np.ndarray
    ids: np.ndarray
    rested: bool


def _read_part(curves: UsdGeom.BasisCurves) -> _Part:
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
    given = widths(curves, counts)
    ids = strand_ids(curves, len(counts))
    lines = list[np.ndarray]()
    spare = list[int]()
    faults = dict[int, BadInput]()
    for i, strand in enumerate(strands):
        try:
            line, beyond = _polyline(
                curves, np.column_stack([strand, _at_points(given[i], len(strand))]), f"{where} curve {i}"
            )
        except BadInput as fault:
            faults[i] = fault
            continue
        if len(given[i]) != len(strand):
            line[:, 6] = _between(given[i], len(line), beyond)
        line[:, 6] *= scale
        lines.append(line)
        spare.append(beyond)
    _report(faults, len(strands), where)
    kept = np.delete(np.arange(len(strands)), list(faults))
    return _Part(lines, np.array(spare, np.int64), ids[kept], rest is not None)


def _report(faults: dict[int, BadInput], total: int, where: str) -> None:
    """Warn of omitted curves, by their indices; raise the first fault where no curve is left."""
    if faults and len(faults) == total:
        raise next(iter(faults.values()))
    if faults:
        named = ", ".join(map(str, list(faults)[:NAMED])) + (f" and {len(faults) - NAMED} more" * (len(faults) > NAMED))
        why = next(iter(faults.values())).what
        warnings.warn(f"{where}: {len(faults)} of {total} curves are left out: {named}: {why}", stacklevel=3)


def _at_points(values: np.ndarray, count: int) -> np.ndarray:
    """Return widths at `count` points, (count,); unknown ones are interpolated.

    All are NaN where none is known, or where their number does not match.
    """
    known = np.isfinite(values)
    if len(values) != count or not known.any():
        return np.full(count, np.nan)
    return np.interp(np.arange(count), np.flatnonzero(known), values[known])


def _between(values: np.ndarray, rows: int, beyond: int) -> np.ndarray:
    """Return widths at the points of a line, (rows,), from those at the ends of its spans, at equal steps.

    beyond  points of the line before the curve begins
    """
    filled = _at_points(values, len(values))
    return np.interp(np.arange(rows), np.linspace(beyond, rows - 1 - beyond, len(values)), filled)


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


def _polyline(curves: UsdGeom.BasisCurves, points: np.ndarray, where: str) -> tuple[np.ndarray, int]:
    """Return points on a curve pinned at both ends, (n, k) float64, and the number beyond either end of the curve.

    The points of an interpolating curve are unchanged.
    """
    cubic = curves.GetTypeAttr().Get() == UsdGeom.Tokens.cubic
    basis = curves.GetBasisAttr().Get()
    wrap = curves.GetWrapAttr().Get()
    if wrap == UsdGeom.Tokens.periodic:
        raise BadInput("the curve is closed", where=where, right="wrap pinned or nonperiodic")
    if len(points) < 2:
        raise BadInput(f"the curve has {len(points)} points", where=where, right="2 or more")
    if not cubic:
        return points, 0
    pinned = wrap == UsdGeom.Tokens.pinned
    if basis in BEYOND and not pinned and len(points) < 4:
        name = "Catmull-Rom curve" if basis == UsdGeom.Tokens.catmullRom else "B-spline"
        raise BadInput(f"the {name} has {len(points)} points", where=where, right="4 or more, or wrap pinned")
    if basis == UsdGeom.Tokens.catmullRom:
        return points, 0 if pinned else BEYOND[basis]
    if basis == UsdGeom.Tokens.bspline:
        return _bspline(points), 0 if pinned else BEYOND[basis]
    if basis == UsdGeom.Tokens.bezier:
        return _bezier(points, where), 0
    raise BadInput(f"the basis is {basis}", where=where, right="catmullRom, bspline or bezier")


def _bspline(points: np.ndarray) -> np.ndarray:
    """Return points on a uniform cubic B-spline that is pinned by mirroring its ends, p[-1] = 2 p[0] - p[1].

    That of the same points without wrap pinned is the same curve without its first and its last span.
    """
    points = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
    return _sample(BSPLINE, np.arange(len(points) - 3), points)


def _bezier(points: np.ndarray, where: str) -> np.ndarray:
    if len(points) < 4 or len(points) % 3 != 1:
        raise BadInput(f"the Bezier curve has {len(points)} points", where=where, right="4, 7, 10, ...")
    return _sample(BEZIER, np.arange(0, len(points) - 1, 3), points)


def _sample(basis: np.ndarray, spans: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return STEPS points a span and the end of the last; a span s is controlled by points[s:s+4].

    p(t) = (1, t, t^2, t^3) basis (p[s], p[s+1], p[s+2], p[s+3])
    """
    powers = np.vander(np.linspace(0, 1, STEPS + 1), 4, increasing=True)
    curve = np.einsum("tk,kp,spx->stx", powers, basis, points[spans[:, None] + np.arange(4)])
    return np.concatenate([curve[:, :-1].reshape(-1, points.shape[1]), curve[-1, -1:]])
