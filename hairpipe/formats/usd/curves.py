"""Curves of a stage as polylines in metres, with their ids, rest shape, widths, colours, groups, guides and roots.

Those of B-splines, Bezier curves and NURBS pass through points on them.
"""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import UsdGeom

from hairpipe.errors import BadInput
from hairpipe.formats.polylines import join_groups, join_maps, join_values
from hairpipe.formats.usd.stage import (
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
from hairpipe.values.groom import DIAMETERS, Curves

IDS = ("hairId", "groom_id", "id")
"""Primvars of strand ids: ours, Unreal's, Houdini's."""
REST = ("pref", "rest")
"""Primvars of the rest shape: of many renderers, Houdini's."""
ROOT_UV = ("groom_root_uv", "st")
"""Primvars of texture coordinates of roots: Unreal's, of many renderers."""
COLOURS = ("groom_color", "displayColor")
"""Primvars of colours: Unreal's, of all renderers; a constant one is that of a preview, and not used."""
MARKS = ("groom_guide", "groom_group_id", "groom_group_name")
"""Primvars of guides and groups, Unreal's."""
DRAWN = ("displayOpacity", "skinprim", "skinprimuv", "lockId", *ROOT_UV, *COLOURS, *MARKS)
"""Primvars that are read where they have a value for each curve, and those computed here: places of roots, locks."""
GUIDED = ("groom_closest_guides", "groom_guide_weights")
"""Primvars of the guides of each strand, and of their weights: Unreal's; not read."""
KNOWN = {*IDS, *REST, *DRAWN, "widths", DIAMETERS}
"""Primvars that have a meaning; others are maps."""
LARGEST = np.iinfo(np.int32).max
NONE = np.iinfo(np.int64).min
"""Id of a curve without an id."""


def widths(curves: UsdGeom.Curves, counts: np.ndarray) -> list[np.ndarray]:
    """Return the widths along each curve in units of the curves, (n,) float64; NaN if unknown.

    They are the diameters of the hair, where the file has these in addition to the widths of a picture.
    A curve has one width, as many as points, or as many as ends of spans (varying).

    counts  of the points of each curve, (S,)
    """
    values = _primvar(curves, DIAMETERS, 1)
    if values is None:
        values = _primvar(curves, "widths", 1)
    if values is None and curves.GetWidthsAttr().HasValue():
        attribute = curves.GetWidthsAttr()
        values = shaped(attribute.Get(time_of(curves.GetPrim())), attribute)
    if values is None:
        return [np.full(1, np.nan)] * len(counts)
    bad = ~(np.isfinite(values) & (values >= 0.0))
    if bad.any():
        what = f"widths: {bad.sum()} of {len(values)} are negative or not finite"
        warnings.warn(f"{location(curves.GetPrim())}: {what}: replaced by those of neighbouring points", stacklevel=3)
    found = per_curve(curves, "widths", np.where(bad, np.nan, values), counts)
    return [np.full(1, np.nan)] * len(counts) if found is None else found


def per_curve(curves: UsdGeom.Curves, name: str, values: np.ndarray, counts: np.ndarray) -> list[np.ndarray] | None:
    """Return the values of each curve: one, one a point, or one at each end of a span; None, with a warning."""
    varying = span_ends(curves, counts)
    layouts = {1: None, len(counts): np.ones(len(counts), int), counts.sum(): counts, varying.sum(): varying}
    if len(values) not in layouts:
        fitting = " or ".join(map(str, sorted(layouts)))
        size = f"{len(counts)} curves of {counts.sum()} points"
        _warn(curves, f"{name} are {len(values)} values for {size}, not {fitting}")
        return None
    layout = layouts[len(values)]
    return [values] * len(counts) if layout is None else np.split(values, np.cumsum(layout)[:-1])


def colours(curves: UsdGeom.Curves, counts: np.ndarray) -> list[np.ndarray] | None:
    """Return the colours along each curve, (n, 3) float64, as of `widths`; None without, or with one for all curves."""
    for name in COLOURS:
        values = _primvar(curves, name, 3)
        if values is not None and len(values) > 1:
            return per_curve(curves, name, values, counts)
    return None


def root_uv(curves: UsdGeom.Curves, counts: np.ndarray) -> np.ndarray | None:
    """Return the texture coordinates of the roots, (S, 2) float32; None without."""
    for name in ROOT_UV:
        values = _primvar(curves, name, 2)
        found = None if values is None else per_curve(curves, name, values, counts)
        if found is not None and len(counts):
            return np.array([rows[0] for rows in found], np.float32)
    return None


def guides(curves: UsdGeom.Curves, count: int) -> np.ndarray | None:
    """Return whether each of `count` curves is a guide, (count,) bool; None where the file does not state it."""
    values = _matching(curves, ("groom_guide",), 1, (1, count), f"{count} curves")
    if values is not None:
        return np.broadcast_to(values, count) != 0
    return np.ones(count, bool) if curves.ComputePurpose() == UsdGeom.Tokens.guide else None


def groups(curves: UsdGeom.Curves, count: int) -> np.ndarray | None:
    """Return the group of each of `count` curves, (count,): its name, or else its id, as text; None without groups."""
    primvar = UsdGeom.PrimvarsAPI(curves).GetPrimvar("groom_group_name")
    names = np.array(primvar.ComputeFlattened(time_of(curves.GetPrim())) if primvar.HasValue() else [], str).ravel()
    if len(names) in (1, count):
        return np.broadcast_to(names, count)
    if len(names):
        _warn(curves, f"primvars:groom_group_name has {len(names)} values for {count} curves")
    ids = _matching(curves, ("groom_group_id",), 1, (1, count), f"{count} curves")
    return None if ids is None else np.array([f"{value:g}" for value in np.broadcast_to(ids, count)], str)


def span_ends(curves: UsdGeom.Curves, counts: np.ndarray) -> np.ndarray:
    """Return the number of varying values of each curve, (S,): one at each end of a span."""
    if not curves.GetPrim().IsA(UsdGeom.BasisCurves) or curves.GetTypeAttr().Get() != UsdGeom.Tokens.cubic:
        return counts
    if curves.GetBasisAttr().Get() == UsdGeom.Tokens.bezier:
        return np.maximum(counts - 1, 0) // 3 + 1
    return counts if curves.GetWrapAttr().Get() == UsdGeom.Tokens.pinned else np.maximum(counts - 2, 0)


def own_ids(ids: np.ndarray, path: Path) -> np.ndarray:
    """Return an id for each of the curves of all prims, (S,) int32.

    Curves without an id, and all but the first with the same id, get the lowest free numbers.

    ids  of the prims, (S,), or NONE
    """
    _, first = np.unique(ids, return_index=True)
    kept = np.zeros(len(ids), bool)
    kept[first] = True
    kept &= ids != NONE
    free = np.setdiff1d(np.arange(len(ids)), ids[kept])
    if kept.any() and not kept.all():
        message = f"ids of {(~kept).sum()} of {len(ids)} curves are missing or repeated, and get new numbers"
        warnings.warn(f"{path}: {message}", stacklevel=2)
    found = ids.copy()
    found[~kept] = free[: (~kept).sum()]
    return found.astype(np.int32)


def maps(curves: UsdGeom.Curves, count: int) -> dict[str, np.ndarray]:
    """Return the primvars without another meaning that are a finite number for each of `count` curves, (count,)."""
    found = {}
    for primvar in _other_primvars(curves):
        values = np.array(primvar.ComputeFlattened(time_of(curves.GetPrim())))
        if values.shape == (count,) and values.dtype.kind in "iuf" and np.isfinite(values).all():
            found[str(primvar.GetPrimvarName())] = values.astype(np.float64)
    return found


def _other_primvars(curves: UsdGeom.Curves) -> list[UsdGeom.Primvar]:
    return [p for p in UsdGeom.PrimvarsAPI(curves).GetPrimvarsWithValues() if p.GetPrimvarName() not in KNOWN]


def _matching(
    curves: UsdGeom.Curves, names: Sequence[str], columns: int, counts: Sequence[int], noun: str
) -> np.ndarray | None:
    """Return the first of some primvars with as many values as one of the counts; warn of others."""
    for name in names:
        values = _primvar(curves, name, columns)
        if values is not None and len(values) in counts:
            return values
        if values is not None:
            _warn(curves, f"primvars:{name} has {len(values)} values for {noun}")
    return None


def _primvar(curves: UsdGeom.Curves, name: str, columns: int) -> np.ndarray | None:
    """Return the flattened values of a primvar at the time of the stage; None where they are not numbers."""
    primvar = UsdGeom.PrimvarsAPI(curves).GetPrimvar(name)
    if not primvar.HasValue():
        return None
    values = np.array(primvar.ComputeFlattened(time_of(curves.GetPrim())))
    shape = values.ndim == (1 if columns == 1 else 2) and values.shape[1:] in ((), (columns,))
    if shape and values.dtype.kind in "iuf":
        return values.astype(np.float64)
    _warn(curves, f"primvars:{name} is not an array of numbers, {columns} each")
    return None


def _warn(curves: UsdGeom.Curves, what: str) -> None:
    warnings.warn(f"{location(curves.GetPrim())}: {what}: not used", stacklevel=3)


STEPS = 8  # chords per span of an approximating cubic: an error of 1/64 of its sagitta
BEYOND = {UsdGeom.Tokens.catmullRom: 1, UsdGeom.Tokens.bspline: STEPS}
"""Number of points at either end that a curve without pins does not reach."""
BSPLINE = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
BEZIER = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1.0]])
CUBIC = 4  # order of a NURBS curve
NAMED = 5  # number of curves in a message


class Nurbs:
    """Orders, knots and weights of the curves of a prim.

    orders   (S,) int64
    knots    of each curve, (n + order,) float64
    weights  of the points of each curve, (n,) float64
    """

    def __init__(self, curves: UsdGeom.NurbsCurves, counts: np.ndarray, where: str) -> None:
        orders = numbers(curves.GetOrderAttr(), kind=np.int64)
        knots, weights = (numbers(a) for a in (curves.GetKnotsAttr(), curves.GetPointWeightsAttr()))
        if len(orders) != len(counts):
            right = f"one for each of {len(counts)} curves"
            raise BadInput(f"order has {len(orders)} values", where=where, right=right)
        if len(knots) != (counts + orders).sum():
            right = f"points and order of each curve, {(counts + orders).sum()} in all"
            raise BadInput(f"there are {len(knots)} knots", where=where, right=right)
        if len(weights) not in (0, counts.sum()) or (weights <= 0.0).any():
            right = f"a positive number for each of {counts.sum()} points, or none"
            raise BadInput(f"pointWeights has {len(weights)} values", where=where, right=right)
        ranges = numbers(curves.GetRangesAttr(), 2)
        self.orders = orders
        self.knots = np.split(knots, np.cumsum(counts + orders)[:-1])
        self.weights = np.split(weights if len(weights) else np.ones(counts.sum()), np.cumsum(counts)[:-1])
        pairs = zip(self.knots, orders, strict=True)
        whole = [(own[order - 1], own[-order]) for own, order in pairs if len(own) > order]
        if len(ranges) and not (len(ranges) == len(whole) and np.allclose(ranges, whole)):
            raise BadInput("ranges are parts of the curves", where=where, right="those of the knots, or none")

    def polyline(self, i: int, points: np.ndarray, where: str) -> tuple[np.ndarray, int]:
        """Return STEPS points a span of curve i and its end, from its control points (n, k), and 0; (m, k) float64."""
        knots = self.knots[i]
        weights = self.weights[i][:, None]
        if self.orders[i] != CUBIC:
            what = f"the NURBS curve has the order {self.orders[i]}"
            raise BadInput(what, where=where, right=f"{CUBIC}: a cubic one")
        if len(points) < CUBIC:
            raise BadInput(f"the NURBS curve has {len(points)} points", where=where, right=f"{CUBIC} or more")
        if len(points) > CUBIC and np.array_equal(points[: CUBIC - 1, :3], points[1 - CUBIC :, :3]):
            raise BadInput("the NURBS curve is periodic", where=where, right="an open curve, with a root and a tip")
        spans = np.flatnonzero(np.diff(knots[CUBIC - 1 : 1 - CUBIC]) > 0.0) + CUBIC - 1
        if (np.diff(knots) < 0.0).any() or not len(spans):
            raise BadInput("the knots do not ascend", where=where, right="knots that ascend")
        at = np.concatenate([np.linspace(knots[s], knots[s + 1], STEPS, endpoint=False) for s in spans])
        at = np.append(at, knots[spans[-1] + 1])
        owners = np.append(np.repeat(spans, STEPS), spans[-1])
        return de_boor(knots, owners, at, np.hstack([points * weights, weights])), 0


def de_boor(knots: np.ndarray, spans: np.ndarray, at: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return places on a cubic NURBS curve by de Boor's algorithm, (m, k); pure.

    spans   span of each parameter: knots[s] <= t <= knots[s+1], (m,)
    at      parameters, (m,)
    points  control points times their weights, and the weights in the last column, (n, k+1)
    """
    degree = CUBIC - 1
    rows = points[spans[:, None] + np.arange(-degree, 1)]
    for level in range(1, CUBIC):
        for j in range(degree, level - 1, -1):
            low = knots[spans + j - degree]
            high = knots[spans + j + 1 - level]
            share = ((at - low) / np.where(high > low, high - low, 1.0))[:, None]
            rows[:, j] = (1.0 - share) * rows[:, j - 1] + share * rows[:, j]
    return rows[:, degree, :-1] / rows[:, degree, -1:]


def polyline(curves: UsdGeom.Curves, points: np.ndarray, where: str) -> tuple[np.ndarray, int]:
    """Return points on a curve pinned at both ends, (n, k), and the number beyond either end of the curve."""
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
        # Pinned by mirroring the ends, p[-1] = 2 p[0] - p[1]; without pins the first and last span are omitted.
        points = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
        return _sample(BSPLINE, np.arange(len(points) - 3), points), 0 if pinned else BEYOND[basis]
    if basis == UsdGeom.Tokens.bezier:
        if len(points) < 4 or len(points) % 3 != 1:
            raise BadInput(f"the Bezier curve has {len(points)} points", where=where, right="4, 7, 10, ...")
        return _sample(BEZIER, np.arange(0, len(points) - 1, 3), points), 0
    raise BadInput(f"the basis is {basis}", where=where, right="catmullRom, bspline or bezier")


def _sample(basis: np.ndarray, spans: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return STEPS points a span s and the end of the last: p(t) = (1, t, t^2, t^3) basis (p[s], ..., p[s+3])."""
    powers = np.vander(np.linspace(0, 1, STEPS + 1), 4, increasing=True)
    curve = np.einsum("tk,kp,spx->stx", powers, basis, points[spans[:, None] + np.arange(4)])
    return np.concatenate([curve[:, :-1].reshape(-1, points.shape[1]), curve[-1, -1:]])


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
    time    time code; by default the first at which all meshes and curves have samples
    guides  whether curves of purpose guide are read in any case
    absent  whether absent files of the stage are refused, or warned of

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim and the curve.
    """
    with usd_faults(path):
        stage = open_whole(path, prim, absent)
        go_to(stage, time)
        kinds = (UsdGeom.BasisCurves, UsdGeom.NurbsCurves)
        found = shown(stage, prim, *kinds, guides="also" if guides else "only")
        prims = [(UsdGeom.NurbsCurves if p.IsA(UsdGeom.NurbsCurves) else UsdGeom.BasisCurves)(p) for p in found]
        parts = [_read_part(curves) for curves in prims]
        time = read_time([curves.GetPrim() for curves in prims], time)
        unused = set[str]()
        for curves, part in zip(prims, parts, strict=True):
            unused |= {str(p.GetPrimvarName()) for p in _other_primvars(curves)} - part.maps.keys()
    if unused:
        warnings.warn(f"{path}: primvars that are not used: {', '.join(sorted(unused))}", stacklevel=2)
    lines = [line for part in parts for line in part.lines]
    if not lines:
        raise BadInput("the curves have no points", where=path, right="at least one curve")
    columns = np.concatenate(lines)
    sizes = [len(part.ids) for part in parts]
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
        join_values([part.uv for part in parts], sizes, 0.0),
        *join_groups([part.groups for part in parts], sizes, [curves.GetPrim().GetName() for curves in prims]),
        join_values([part.guides for part in parts], sizes, False),
        np.nan_to_num(columns[:, 7:]).astype(np.float32) if any(part.coloured for part in parts) else None,
        join_maps([part.maps for part in parts], sizes),
    )


class _Part(NamedTuple):
    """The curves of one prim, with values of each strand, (S,); see `Curves`.

    lines     points of each with rest shape, width and colour, (n, 10) float64; NaN without a width or colour
    ids       ids of the prim, or NONE
    rested    whether the prim has a rest shape, and coloured: whether it has colours
    groups    group of each strand as text
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
    rest = _matching(curves, REST, 3, (len(points),), f"{len(points)} points")
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
            line, beyond = nurbs.polyline(i, whole, place_of) if nurbs else polyline(curves, whole, place_of)
        except BadInput as fault:
            faults[i] = fault
            continue
        for column, held in zip((slice(6, 7), slice(7, 10)), given[i], strict=True):
            if len(held) != len(strand):
                ends = np.linspace(beyond, len(line) - 1 - beyond, len(held))  # of spans, at equal steps
                known = _at_points(held, len(held))
                line[:, column] = np.stack([np.interp(np.arange(len(line)), ends, k) for k in known.T], axis=1)
        lines.append(line)
        spare.append(beyond)
    _report(faults, len(strands), where)
    kept = np.delete(np.arange(len(strands)), list(faults))
    marks = (root_uv(curves, counts), groups(curves, len(counts)), guides(curves, len(counts)))
    uv, group, is_guide = (None if mark is None else mark[kept] for mark in marks)
    ids = _matching(curves, IDS, 1, (len(counts),), f"{len(counts)} curves")
    ids = np.full(len(counts), np.nan) if ids is None else ids
    is_id = (ids == np.rint(ids)) & (np.abs(ids) <= LARGEST)
    ids = np.where(is_id, ids, NONE).astype(np.int64)[kept]
    painted = {name: values[kept] for name, values in maps(curves, len(counts)).items()}
    beyond_ends = np.array(spare, np.int64)
    return _Part(lines, beyond_ends, ids, rest is not None, tint is not None, uv, group, is_guide, painted)


def _report(faults: dict[int, BadInput], total: int, where: str) -> None:
    """Warn of omitted curves, by their indices; raise the first fault where no curve is left."""
    if faults and len(faults) == total:
        raise next(iter(faults.values()))
    if faults:
        named = ", ".join(map(str, list(faults)[:NAMED])) + (f" and {len(faults) - NAMED} more" * (len(faults) > NAMED))
        why = next(iter(faults.values())).what
        warnings.warn(f"{where}: {len(faults)} of {total} curves are left out: {named}: {why}", stacklevel=3)


def _at_points(values: np.ndarray, count: int) -> np.ndarray:
    """Return values, (n, k), at `count` points, unknown ones interpolated; NaN if none is known, or n is another."""
    known = np.isfinite(values).all(axis=1)
    if len(values) != count or not known.any():
        return np.full((count, values.shape[1]), np.nan)
    places = np.flatnonzero(known)
    return np.stack([np.interp(np.arange(count), places, column[known]) for column in values.T], axis=1)


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
