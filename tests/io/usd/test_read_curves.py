"""Curves come as polylines in metres, Y up, root first: their own points, or points on the curve."""

from collections.abc import Callable

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt
from scipy.interpolate import BSpline

from hairpipe.errors import BadInput
from hairpipe.io.usd.curves import STEPS, read
from hairpipe.io.usd.read import read_curves

TOKENS = UsdGeom.Tokens


def curves(
    stage: Usd.Stage,
    strands: list[np.ndarray],
    basis: str = TOKENS.catmullRom,
    wrap: str = TOKENS.pinned,
    kind: str = TOKENS.cubic,
    path: str = "/groom/hair",
) -> UsdGeom.BasisCurves:
    prim = UsdGeom.BasisCurves.Define(stage, path)
    prim.CreateTypeAttr(kind)
    prim.CreateBasisAttr(basis)
    prim.CreateWrapAttr(wrap)
    prim.CreateCurveVertexCountsAttr([len(strand) for strand in strands])
    points = np.concatenate(strands) if strands else np.empty((0, 3))
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    return prim


def wild(*counts: int) -> list[np.ndarray]:
    generator = np.random.default_rng(5)
    return [generator.random((count, 3)) for count in counts]


@pytest.mark.parametrize(("up", "scale"), [("Y", 1.0), ("Y", 0.01), ("Z", 1.0), ("Z", 0.01)])
def test_merges_all_prims_in_metres_with_y_up(new_stage, saved, up: str, scale: float) -> None:
    stage = new_stage(up, scale)
    first, second = wild(4, 7), wild(3)
    curves(stage, first)
    curves(stage, second, kind=TOKENS.linear, wrap=TOKENS.nonperiodic, path="/groom/other")
    UsdGeom.Xform(stage.GetPrimAtPath("/groom/other")).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    points, offsets = read(saved(stage), None)
    x, y, z = scale * np.concatenate([*first, second[0] + np.array([1, 2, 3])]).T
    np.testing.assert_allclose(points, np.stack([x, y, z] if up == "Y" else [x, z, -y], axis=1), atol=3e-7 * scale)
    assert offsets.tolist() == [0, 4, 11, 14] and offsets.dtype == np.int32 and points.dtype == np.float64
    assert len(read(saved(stage), "/groom/other")[0]) == 3


def test_a_pinned_catmull_rom_curve_is_its_own_points(new_stage, saved) -> None:
    stage, strands = new_stage(), wild(5, 2)
    curves(stage, strands, wrap=TOKENS.pinned)
    np.testing.assert_allclose(read(saved(stage), None)[0], np.concatenate(strands), atol=1e-7)


def test_without_pins_a_catmull_rom_curve_ends_at_its_last_points_but_one(new_stage, saved) -> None:
    stage, (long, short) = new_stage(), wild(5, 4)
    curves(stage, [long, short], wrap=TOKENS.nonperiodic)
    np.testing.assert_allclose(read(saved(stage), None)[0], np.concatenate([long[1:-1], short[1:-1]]), atol=1e-7)


def test_b_spline_lies_on_the_curve(new_stage, saved) -> None:
    stage, (strand,) = new_stage(), wild(6)
    curves(stage, [strand], TOKENS.bspline, TOKENS.nonperiodic)
    points, offsets = read(saved(stage), None)
    spline = BSpline(np.arange(-3.0, 7.0), strand, 3)
    np.testing.assert_allclose(points, spline(np.linspace(0, 3, 3 * STEPS + 1)), atol=1e-6)
    assert offsets.tolist() == [0, len(points)]


@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_pinned_b_spline_begins_and_ends_at_its_points(new_stage, saved, count: int) -> None:
    stage, (strand,) = new_stage(), wild(count)
    curves(stage, [strand], TOKENS.bspline)
    points, _ = read(saved(stage), None)
    np.testing.assert_allclose(points[[0, -1]], strand[[0, -1]], atol=1e-6)
    assert len(points) == (count - 1) * STEPS + 1


def de_casteljau(control: np.ndarray, t: float) -> np.ndarray:
    while len(control) > 1:
        control = (1 - t) * control[:-1] + t * control[1:]
    return control[0]


def test_bezier_lies_on_the_curve(new_stage, saved) -> None:
    stage, (strand,) = new_stage(), wild(7)
    curves(stage, [strand], TOKENS.bezier, TOKENS.nonperiodic)
    t = np.linspace(0, 1, STEPS + 1)
    spans = [np.array([de_casteljau(strand[s : s + 4], u) for u in t]) for s in (0, 3)]
    np.testing.assert_allclose(read(saved(stage), None)[0], np.concatenate([spans[0][:-1], spans[1]]), atol=1e-6)


def test_the_door_reads_the_same(new_stage, saved) -> None:
    stage = new_stage("Z", 0.01)
    curves(stage, wild(4, 7))
    path = saved(stage)
    for told, seen in zip(read_curves(path), read(path, None), strict=True):
        np.testing.assert_array_equal(told, seen)


def test_takes_the_earliest_time(new_stage, saved) -> None:
    stage = new_stage()
    points = curves(stage, wild(4)).GetPointsAttr()
    points.Clear()
    for time in (3, 1, 2):
        points.Set(Vt.Vec3fArray(4, Gf.Vec3f(time)), time)
    assert (read(saved(stage), None)[0] == 1).all()


def test_takes_guides_only_where_there_is_nothing_else(new_stage, saved) -> None:
    stage, (guide, hair, proxy) = new_stage(), wild(4, 7, 3)
    curves(stage, [guide], path="/groom/guides").CreatePurposeAttr(TOKENS.guide)
    curves(stage, [proxy], path="/groom/proxy").CreatePurposeAttr(TOKENS.proxy)
    np.testing.assert_allclose(read(saved(stage), None)[0], guide, atol=1e-7)
    curves(stage, [hair], path="/groom/hair").CreatePurposeAttr(TOKENS.render)
    np.testing.assert_allclose(read(saved(stage), None)[0], hair, atol=1e-7)
    np.testing.assert_allclose(read(saved(stage), "/groom/guides")[0], guide, atol=1e-7)
    with pytest.raises(BadInput, match="no visible BasisCurves at or under /groom/proxy"):
        read(saved(stage), "/groom/proxy")


BROKEN: dict[str, tuple[Callable[[Usd.Stage], object], str]] = {
    "none": (lambda s: UsdGeom.Xform.Define(s, "/groom"), "no visible BasisCurves"),
    "empty": (lambda s: curves(s, []), "the curves have no points"),
    "no counts": (lambda s: UsdGeom.BasisCurves.Define(s, "/groom/hair"), "the curves have no points"),
    "counts": (lambda s: curves(s, wild(4)).CreateCurveVertexCountsAttr([5]), "curveVertexCounts sum to 5"),
    "negative": (lambda s: curves(s, wild(4)).CreateCurveVertexCountsAttr([-1, 5]), "curveVertexCounts sum to 4"),
    "NaN": (lambda s: curves(s, [np.full((4, 3), np.nan)]), "points: element 0 is not finite"),
    "one point": (lambda s: curves(s, wild(4, 1)), "curve 1: the curve has 1 points"),
    "closed": (lambda s: curves(s, wild(4), wrap=TOKENS.periodic), "the curve is closed"),
    "short": (lambda s: curves(s, wild(3), wrap=TOKENS.nonperiodic), "the Catmull-Rom curve has 3 points"),
    "short bspline": (lambda s: curves(s, wild(3), TOKENS.bspline, TOKENS.nonperiodic), "the B-spline has 3 points"),
    "short bezier": (lambda s: curves(s, wild(4, 6), TOKENS.bezier), "curve 1: the Bezier curve has 6 points"),
    "basis": (lambda s: curves(s, wild(4), "hermite"), "the basis is hermite"),
}


@pytest.mark.parametrize(("plant", "message"), BROKEN.values(), ids=BROKEN)
def test_refuses_what_is_broken_and_says_where(new_stage, saved, plant: Callable, message: str) -> None:
    stage = new_stage()
    plant(stage)
    with pytest.raises(BadInput) as caught:
        read(saved(stage), None)
    assert message in str(caught.value) and "given.usda" in str(caught.value)
