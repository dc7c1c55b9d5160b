"""NURBS curves against those of scipy."""

from itertools import pairwise

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt
from scipy.interpolate import BSpline

from hairpipe.errors import BadInput
from hairpipe.formats.usd.curves import STEPS, read_curves

TOKENS = UsdGeom.Tokens


def wild(*counts: int) -> list[np.ndarray]:
    generator = np.random.default_rng(5)
    return [generator.random((count, 3)) for count in counts]


def nurbs(
    stage: Usd.Stage, strands: list[np.ndarray], knots: list[np.ndarray], weights: list[np.ndarray] | None = None
):
    prim = UsdGeom.NurbsCurves.Define(stage, "/groom/nurbs")
    prim.CreateCurveVertexCountsAttr([len(strand) for strand in strands])
    prim.CreateOrderAttr([4] * len(strands))
    prim.CreateKnotsAttr(np.concatenate(knots).tolist())
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.concatenate(strands).astype(np.float32)))
    if weights is not None:
        prim.CreatePointWeightsAttr(np.concatenate(weights).tolist())
    return prim


CLAMPED = [np.array([0, 0, 0, 0, 1, 2.5, 2.5, 3, 3, 3, 3.0]), np.array([-1, 0, 0.5, 1, 3, 4, 5, 6.0])]


@pytest.mark.parametrize("weighted", [False, True])
def test_nurbs_lie_on_the_curves_of_scipy(new_stage, saved, weighted: bool) -> None:
    stage, strands = new_stage(), wild(7, 4)
    weights = [np.linspace(1, 3, len(s)) if weighted else np.ones(len(s)) for s in strands]
    prim = nurbs(stage, strands, CLAMPED, weights if weighted else None)
    prim.CreateWidthsAttr(np.arange(11) / 100.0)
    prim.SetWidthsInterpolation(TOKENS.vertex)
    found = read_curves(saved(stage), None)
    for s, (points, knots, weight) in enumerate(zip(strands, CLAMPED, weights, strict=True)):
        line = found.points[found.offsets[s] : found.offsets[s + 1]]
        ends = np.unique(knots[3:-3])
        spans = [np.linspace(a, b, STEPS, endpoint=False) for a, b in pairwise(ends)]
        at = np.append(np.concatenate(spans), ends[-1])
        homogeneous = BSpline(knots, np.hstack([np.float32(points) * weight[:, None], weight[:, None]]), 3)(at)
        np.testing.assert_allclose(line, homogeneous[:, :3] / homogeneous[:, 3:], atol=1e-12)
    assert np.allclose(found.points[0], strands[0][0]) and found.widths is not None
    assert found.widths[0] == pytest.approx(0.0) and found.widths[found.offsets[1] - 1] == pytest.approx(0.06)


BROKEN_NURBS = {
    "periodic": ([np.vstack([wild(5)[0], wild(5)[0][:3]])], [np.arange(12.0)], "the NURBS curve is periodic"),
    "short": (wild(3), [np.arange(7.0)], "the NURBS curve has 3 points"),
    "knots": (wild(5), [np.arange(8.0)], "there are 8 knots (points and order of each curve, 9 in all)"),
    "descending": (wild(5), [np.arange(9.0)[::-1]], "the knots do not ascend"),
}


@pytest.mark.parametrize(("strands", "knots", "message"), BROKEN_NURBS.values(), ids=BROKEN_NURBS)
def test_other_nurbs_are_refused(new_stage, saved, strands, knots, message: str) -> None:
    stage = new_stage()
    nurbs(stage, strands, knots)
    with pytest.raises(BadInput) as caught:
        read_curves(saved(stage), None)
    assert message in str(caught.value) and "/groom/nurbs" in str(caught.value)


def test_quadratic_nurbs_and_parts_of_curves_are_refused(new_stage, saved) -> None:
    stage = new_stage()
    nurbs(stage, wild(5), [np.arange(9.0)]).CreateRangesAttr([Gf.Vec2d(3.5, 5.0)])
    with pytest.raises(BadInput, match="ranges are parts of the curves"):
        read_curves(saved(stage), None)
    stage = new_stage(name="quadratic.usda")
    nurbs(stage, wild(6), [np.arange(9.0)]).CreateOrderAttr([3])
    with pytest.raises(BadInput, match="has the order 3"):
        read_curves(saved(stage), None)
