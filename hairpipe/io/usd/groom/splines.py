"""Shapes of curves: polylines through the points of B-splines, Bezier curves and NURBS; others are their points."""

import numpy as np
from pxr import UsdGeom

from hairpipe.errors import BadInput
from hairpipe.io.usd.stage import numbers

STEPS = 8  # chords per span of an approximating cubic: an error of 1/64 of its sagitta
BEYOND = {UsdGeom.Tokens.catmullRom: 1, UsdGeom.Tokens.bspline: STEPS}
"""Number of points at either end that a curve without pins does not reach."""
BSPLINE = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
BEZIER = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1.0]])
CUBIC = 4  # order of a NURBS curve


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
            raise BadInput(
                f"order has {len(orders)} values", where=where, right=f"one for each of {len(counts)} curves"
            )
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
        whole = [
            (own[order - 1], own[-order]) for own, order in zip(self.knots, orders, strict=True) if len(own) > order
        ]
        if len(ranges) and not (len(ranges) == len(whole) and np.allclose(ranges, whole)):
            raise BadInput("ranges are parts of the curves", where=where, right="those of the knots, or none")

    def polyline(self, i: int, points: np.ndarray, where: str) -> np.ndarray:
        """Return STEPS points a span of curve i and its end, from its control points (n, k); (m, k) float64."""
        knots = self.knots[i]
        weights = self.weights[i][:, None]
        if self.orders[i] != CUBIC:
            raise BadInput(
                f"the NURBS curve has the order {self.orders[i]}", where=where, right=f"{CUBIC}: a cubic one"
            )
        if len(points) < CUBIC:
            raise BadInput(f"the NURBS curve has {len(points)} points", where=where, right=f"{CUBIC} or more")
        if len(points) > CUBIC and np.array_equal(points[: CUBIC - 1, :3], points[1 - CUBIC :, :3]):
            raise BadInput("the NURBS curve is periodic", where=where, right="an open curve, with a root and a tip")
        spans = np.flatnonzero(np.diff(knots[CUBIC - 1 : 1 - CUBIC]) > 0.0) + CUBIC - 1
        if (np.diff(knots) < 0.0).any() or not len(spans):
            raise BadInput("the knots do not ascend", where=where, right="knots that ascend")
        at = np.concatenate([np.linspace(knots[s], knots[s + 1], STEPS, endpoint=False) for s in spans])
        at = np.append(at, knots[spans[-1] + 1])
        return de_boor(knots, np.append(np.repeat(spans, STEPS), spans[-1]), at, np.hstack([points * weights, weights]))


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
