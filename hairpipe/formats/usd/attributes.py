"""Attributes of the curves of a stage: ids, rest shape, widths, colours, groups, guides, places of roots."""

import warnings
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
from pxr import UsdGeom

from hairpipe.formats.usd.stage import location, shaped, time_of
from hairpipe.values.groom import DIAMETERS

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


def rest_points(curves: UsdGeom.Curves, count: int) -> np.ndarray | None:
    """Return the rest shape of `count` points in the space of the curves, (count, 3) float64; None without a match."""
    return _matching(curves, REST, 3, (count,), f"{count} points")


def strand_ids(curves: UsdGeom.Curves, count: int) -> np.ndarray:
    """Return the ids of `count` curves, (count,) int64; NONE for a curve without a valid one."""
    values = _matching(curves, IDS, 1, (count,), f"{count} curves")
    if values is None:
        return np.full(count, NONE)
    whole = (values == np.rint(values)) & (np.abs(values) <= LARGEST)
    return np.where(whole, values, NONE).astype(np.int64)


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


def unused_primvars(curves: UsdGeom.Curves, used: Collection[str]) -> list[str]:
    """List the primvars of curves that are not read, nor used as maps."""
    return sorted({name for p in _other_primvars(curves) if (name := str(p.GetPrimvarName())) not in used})


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
