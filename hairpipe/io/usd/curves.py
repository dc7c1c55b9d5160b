"""Curves of a stage as polylines in metres."""

from pathlib import Path

import numpy as np
from pxr import UsdGeom

from hairpipe.errors import BadInput
from hairpipe.io.usd.stage import location, move, numbers, open_alone, place, shown, usd_faults

STEPS = 8  # chords per span of a cubic that does not pass through its points: off the curve by 1/64 of its sagitta
BSPLINE = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
BEZIER = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1.0]])


def read(path: Path, prim: str | None) -> tuple[np.ndarray, np.ndarray]:
    """Read the visible curves at or under a prim; see `hairpipe.io.usd.read.read_curves`."""
    with usd_faults(path):
        stage = open_alone(path)
        prims = [UsdGeom.BasisCurves(p) for p in shown(stage, UsdGeom.BasisCurves, prim, guides=True)]
        strands = [strand for curves in prims for strand in _read_strands(curves)]
    if not strands:
        raise BadInput("the curves have no points", where=path, right="at least one curve")
    offsets = np.cumsum([0] + [len(strand) for strand in strands]).astype(np.int32)
    return np.concatenate(strands), offsets


def _read_strands(curves: UsdGeom.BasisCurves) -> list[np.ndarray]:
    points = numbers(curves.GetPointsAttr(), 3)
    counts = numbers(curves.GetCurveVertexCountsAttr(), kind=np.int64)
    where = location(curves.GetPrim())
    if counts.sum() != len(points) or (counts < 0).any():
        right = f"the number of points, {len(points)}"
        raise BadInput(f"curveVertexCounts sum to {counts.sum()}", where=where, right=right)
    strands = np.split(move(place(curves.GetPrim()), points), np.cumsum(counts)[:-1]) if len(counts) else []
    return [_polyline(curves, strand, f"{where} curve {i}") for i, strand in enumerate(strands)]


def _polyline(curves: UsdGeom.BasisCurves, points: np.ndarray, where: str) -> np.ndarray:
    """Return the points of a curve that passes through them, else points on the curve, (n, 3) float64."""
    cubic = curves.GetTypeAttr().Get() == UsdGeom.Tokens.cubic
    basis, wrap = curves.GetBasisAttr().Get(), curves.GetWrapAttr().Get()
    if wrap == UsdGeom.Tokens.periodic:
        raise BadInput("the curve is closed", where=where, right="wrap pinned or nonperiodic")
    if len(points) < 2:
        raise BadInput(f"the curve has {len(points)} points", where=where, right="2 or more")
    if not cubic:
        return points
    if basis == UsdGeom.Tokens.catmullRom:
        return _catmull_rom(points, wrap == UsdGeom.Tokens.pinned, where)
    if basis == UsdGeom.Tokens.bspline:
        return _bspline(points, wrap == UsdGeom.Tokens.pinned, where)
    if basis == UsdGeom.Tokens.bezier:
        return _bezier(points, where)
    raise BadInput(f"the basis is {basis}", where=where, right="catmullRom, bspline or bezier")


def _catmull_rom(points: np.ndarray, pinned: bool, where: str) -> np.ndarray:
    """Return the points that a Catmull-Rom curve passes through: without wrap pinned not the first and the last."""
    if pinned:
        return points
    if len(points) < 4:
        raise BadInput(
            f"the Catmull-Rom curve has {len(points)} points", where=where, right="4 or more, or wrap pinned"
        )
    return points[1:-1]


def _bspline(points: np.ndarray, pinned: bool, where: str) -> np.ndarray:
    """Return points on a uniform cubic B-spline; USD pins it by mirroring its ends, p[-1] = 2 p[0] - p[1]."""
    if pinned:
        points = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
    if len(points) < 4:
        raise BadInput(f"the B-spline has {len(points)} points", where=where, right="4 or more, or wrap pinned")
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
    return np.concatenate([curve[:, :-1].reshape(-1, 3), curve[-1, -1:]])
