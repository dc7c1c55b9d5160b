"""What curves of a stage carry besides their points: ids, a rest shape, widths."""

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom

from hairpipe.io.usd.stage import location, numbers

IDS = ("hairId", "groom_id", "id")
"""Primvars that number strands: ours, Unreal's, Houdini's."""
REST = ("pref", "rest")
"""Primvars of the rest shape: of many renderers, Houdini's."""
LARGEST = np.iinfo(np.int32).max


def rest_points(curves: UsdGeom.BasisCurves, count: int) -> np.ndarray | None:
    """Return the rest shape of so many points in the space of the curves, (count, 3) float64; None where none fits."""
    for name in REST:
        values = _primvar(curves, name, 3)
        if values is not None and len(values) == count:
            return values
        if values is not None:
            _warn(curves, f"primvars:{name} has {len(values)} values for {count} points")
    return None


def strand_ids(curves: UsdGeom.BasisCurves, count: int) -> np.ndarray | None:
    """Return the ids of so many curves, (count,) int64; None where there are none that fit."""
    for name in IDS:
        values = _primvar(curves, name, 1)
        if values is None:
            continue
        if len(values) == count and (values == np.rint(values)).all() and (np.abs(values) <= LARGEST).all():
            return values.astype(np.int64)
        _warn(curves, f"primvars:{name} is not a whole number for each of {count} curves")
    return None


def widths(curves: UsdGeom.BasisCurves, counts: np.ndarray) -> np.ndarray:
    """Return the widths at all points in units of the curves, (p,) float64; NaN where there are none that fit.

    counts  of the points of each curve, (S,)
    """
    values = _primvar(curves, "widths", 1)
    if values is None and curves.GetWidthsAttr().HasValue():
        values = numbers(curves.GetWidthsAttr())
    total = int(counts.sum())
    if values is None:
        return np.full(total, np.nan)
    if len(values) not in (1, len(counts), total) or not (values > 0.0).all():
        _warn(curves, f"widths are not positive numbers, 1, {len(counts)} or {total} of them")
        return np.full(total, np.nan)
    if len(values) == len(counts) and len(counts) != total:
        return np.repeat(values, counts)
    return np.broadcast_to(values, total)


def own_ids(parts: Sequence[np.ndarray | None], count: int, path: Path) -> np.ndarray:
    """Return the ids of the curves of all prims, (count,) int32: their places where not all have ids, or ids repeat."""
    given = [ids for ids in parts if ids is not None]
    together = np.concatenate(given) if given else np.zeros(0, np.int64)
    if len(together) == count and len(np.unique(together)) == count:
        return together.astype(np.int32)
    if given:
        warnings.warn(f"{path}: ids of curves are missing or repeat: not used, curves are counted", stacklevel=2)
    return np.arange(count, dtype=np.int32)


def _primvar(curves: UsdGeom.BasisCurves, name: str, columns: int) -> np.ndarray | None:
    """Return the values of a primvar at the earliest time, one by one; None where it has none that are finite."""
    primvar = UsdGeom.PrimvarsAPI(curves).GetPrimvar(name)
    if not primvar.HasValue():
        return None
    values = np.array(primvar.ComputeFlattened(Usd.TimeCode.EarliestTime()))
    shaped = values.ndim == (1 if columns == 1 else 2) and values.shape[1:] in ((), (columns,))
    if shaped and values.dtype.kind in "iuf" and np.isfinite(values).all():
        return values.astype(np.float64)
    _warn(curves, f"primvars:{name} is not an array of finite numbers, {columns} each")
    return None


def _warn(curves: UsdGeom.BasisCurves, what: str) -> None:
    warnings.warn(f"{location(curves.GetPrim())}: {what}: not used", stacklevel=3)
