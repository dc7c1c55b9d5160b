"""Curves of stages come as polylines in metres, Y up, root first: their own points, or points on the curve."""

import re
import warnings
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from scipy.interpolate import BSpline

from hairpipe.errors import BadInput
from hairpipe.formats.registry import read_strands
from hairpipe.formats.usd.curves import STEPS, read_curves
from hairpipe.formats.usd.meshes import read_body

TOKENS, NAN = UsdGeom.Tokens, float("nan")


def read(path: Path, prim: str | None) -> tuple[np.ndarray, np.ndarray]:
    """Points and offsets of curves as the file says that they are: without what pins would add."""
    found = read_curves(path, prim)
    first, last = found.offsets[:-1] + found.spare, found.offsets[1:] - found.spare
    rows = [np.arange(*ends) for ends in zip(first, last, strict=True)]
    return found.points[np.concatenate(rows)], np.cumsum([0, *map(len, rows)]).astype(np.int32)


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


def test_without_pins_a_catmull_rom_curve_loses_its_ends(new_stage, saved) -> None:
    stage, (long, short) = new_stage(), wild(5, 4)
    prim = curves(stage, [long, short], wrap=TOKENS.pinned)
    np.testing.assert_allclose(read(saved(stage), None)[0], np.concatenate([long, short]), atol=1e-7)
    prim.GetWrapAttr().Set(TOKENS.nonperiodic)
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
    reported, seen = read_strands(path, 1.0, "y", None), read_curves(path)
    for name in ("points", "offsets", "ids", "held", "spare"):
        np.testing.assert_array_equal(getattr(reported, name), getattr(seen, name))
    assert reported.rest is seen.rest is reported.widths is seen.widths is None


def primvar(prim: UsdGeom.BasisCurves, name: str, kind: Sdf.ValueTypeName, interpolation: str, values: object) -> None:
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, interpolation).Set(values)


def test_without_pins_the_ends_that_pins_would_give_are_spare(new_stage, saved) -> None:
    stage, (strand,) = new_stage(), wild(6)
    curves(stage, [strand], TOKENS.bspline, TOKENS.nonperiodic, path="/groom/a")
    curves(stage, [strand], TOKENS.catmullRom, TOKENS.nonperiodic, path="/groom/b")
    curves(stage, [strand], TOKENS.bspline, TOKENS.pinned, path="/groom/c")
    found = read_curves(saved(stage), None)
    assert found.spare.tolist() == [STEPS, 1, 0]
    for begin in found.offsets[:-1]:
        np.testing.assert_allclose(found.points[begin], strand[0], atol=1e-6)
    first, third = found.points[: found.offsets[1]], found.points[found.offsets[2] :]
    np.testing.assert_array_equal(first, third)


@pytest.mark.parametrize("name", ["hairId", "groom_id", "id"])
def test_ids_of_the_file_are_taken_over(new_stage, saved, name: str) -> None:
    stage = new_stage()
    for path, ids in (("/groom/a", [7, 3]), ("/groom/b", [12])):
        primvar(curves(stage, wild(*[4] * len(ids)), path=path), name, Sdf.ValueTypeNames.IntArray, TOKENS.uniform, ids)
    assert read_curves(saved(stage), None).ids.tolist() == [7, 3, 12]


@pytest.mark.parametrize(
    ("kind", "ids", "kept"),
    [
        ("IntArray", [4, 4], [4, 0]),
        ("IntArray", [1], [0, 1]),
        ("StringArray", ["a", "b"], [0, 1]),
        ("FloatArray", [0.5, 0.0], [1, 0]),
    ],
)
def test_curves_without_an_id_get_new_numbers(new_stage, saved, kind: str, ids: list, kept: list[int]) -> None:
    stage = new_stage()
    primvar(curves(stage, wild(4, 4)), "hairId", getattr(Sdf.ValueTypeNames, kind), TOKENS.uniform, ids)
    with pytest.warns(
        UserWarning, match=r"ids of 1 of 2 curves|hairId (is not .*|has 1 values for 2 curves): not used"
    ):
        assert read_curves(saved(stage), None).ids.tolist() == kept


@pytest.mark.parametrize("name", ["pref", "rest"])
def test_the_rest_shape_is_read_as_the_points_are(new_stage, saved, name: str) -> None:
    stage, (strand, rest) = new_stage("Z", 0.01), wild(6, 6)
    prim = curves(stage, [strand], TOKENS.bspline, TOKENS.pinned)
    values = Vt.Vec3fArray.FromNumpy(rest.astype(np.float32))
    primvar(prim, name, Sdf.ValueTypeNames.Point3fArray, TOKENS.vertex, values)
    found = read_curves(saved(stage), None)
    prim.GetPointsAttr().Set(values)
    np.testing.assert_allclose(found.rest, read_curves(saved(stage), None).points, atol=1e-9)


def test_mismatched_rest_shape_is_reported(new_stage, saved) -> None:
    stage = new_stage()
    primvar(curves(stage, wild(6)), "pref", Sdf.ValueTypeNames.Point3fArray, TOKENS.vertex, [Gf.Vec3f(0)] * 5)
    with pytest.warns(UserWarning, match="primvars:pref has 5 values for 6 points: not used"):
        assert read_curves(saved(stage), None).rest is None


WIDTHS: list[tuple[tuple[int, ...], list[float], str, list[float] | None]] = [
    ((4, 5), [2.0], "", [2] * 9),
    ((4, 5), [2.0, 3.0], "", [2] * 4 + [3] * 5),
    ((4, 5), [2.0 + i for i in range(9)], "", list(range(2, 11))),
    ((4,), [3.0, 2.0, 1.0, 0.0], "", [3, 2, 1, 0]),
    ((4, 5), [1.0, 0.0, 1.0], "widths are 3 values for 2 curves of 9 points, not 1 or 2 or 9: not used", None),
    (
        (4, 3, 2),
        [3.0, NAN, 1.0, -1.0, 5.0, 5.0, 5.0, NAN, NAN],
        "4 of 9 are negative or not finite.* 1 of 3 curves",
        [3, 2, 1, 1, 5, 5, 5, 3, 3],
    ),
]
"""Numbers of points, widths of the file, a warning, and the widths of the points."""


@pytest.mark.parametrize(("counts", "given", "message", "expected"), WIDTHS)
def test_widths_are_those_of_the_points_in_metres(new_stage, saved, counts, given, message, expected) -> None:
    stage = new_stage("Y", 0.01)
    curves(stage, wild(*counts)).CreateWidthsAttr(given)
    with warnings.catch_warnings(record=True) as reported:
        warnings.simplefilter("always")
        found = read_curves(saved(stage), None).widths
    assert re.search(message, " ".join(str(warning.message) for warning in reported)) and bool(message) == bool(
        reported
    )
    assert found is expected is None or np.allclose(found, 0.01 * np.array(expected))


@pytest.mark.parametrize(
    ("basis", "wrap", "count", "ends"),
    [
        (TOKENS.bspline, TOKENS.nonperiodic, 9, range(STEPS, 7 * STEPS + 1, STEPS)),
        (TOKENS.bezier, TOKENS.nonperiodic, 10, range(0, 3 * STEPS + 1, STEPS)),
        (TOKENS.catmullRom, TOKENS.nonperiodic, 6, range(1, 5)),
    ],
)
def test_varying_widths_lie_at_the_ends_of_spans(
    new_stage, saved, basis: str, wrap: str, count: int, ends: range
) -> None:
    stage = new_stage()
    prim = curves(stage, wild(count), basis, wrap)
    values = 1.0 + np.arange(prim.ComputeVaryingDataSize(0)) ** 2
    prim.CreateWidthsAttr(values)
    prim.SetWidthsInterpolation(TOKENS.varying)
    found = read_curves(saved(stage), None).widths
    np.testing.assert_allclose(found[list(ends)], values)
    half = found[ends[0] : ends[-1] + 1]
    np.testing.assert_allclose(half, np.interp(np.arange(len(half)), np.array(ends) - ends[0], values))


@pytest.mark.parametrize("bad", [1, 3])
def test_a_curve_that_is_none_does_not_take_the_others_along(new_stage, saved, bad: int) -> None:
    stage, strands = new_stage(), wild(4, 7)
    prim = curves(stage, [strands[0], *wild(bad), strands[1]], wrap=TOKENS.nonperiodic)
    primvar(prim, "hairId", Sdf.ValueTypeNames.IntArray, TOKENS.uniform, [5, 6, 7])
    with pytest.warns(UserWarning, match=rf"hair: 1 of 3 curves are left out: 1: .* {bad} points"):
        found = read_curves(saved(stage), None)
    assert found.ids.tolist() == [5, 7] and len(found.points) == 11


def test_primvars_are_maps_and_those_that_cannot_be_are_named(new_stage, saved) -> None:
    stage = new_stage()
    prim = curves(stage, wild(4))
    primvar(prim, "clump", Sdf.ValueTypeNames.FloatArray, TOKENS.uniform, [0.5])
    primvar(prim, "note", Sdf.ValueTypeNames.StringArray, TOKENS.uniform, ["a"])
    curves(stage, wild(4), path="/groom/hidden").CreateVisibilityAttr("invisible")
    UsdGeom.HermiteCurves.Define(stage, "/groom/hermite")
    with pytest.warns(UserWarning) as reported:
        found = read_curves(saved(stage), None)
    messages = " ".join(str(warning.message) for warning in reported)
    assert "primvars that are not used: note" in messages and found.maps["clump"] == [0.5]
    assert "shapes that are not read: /groom/hidden (invisible), /groom/hermite (a HermiteCurves)" in messages


def test_maps_of_several_prims_are_joined_and_follow_the_kept_curves(new_stage, saved) -> None:
    stage, floats = new_stage(), Sdf.ValueTypeNames.FloatArray
    first = curves(stage, wild(4, 1, 5))
    primvar(first, "clump", floats, TOKENS.uniform, [1.0, 2.0, 3.0])
    primvar(first, "broken", floats, TOKENS.uniform, [1.0, NAN, 3.0])
    primvar(curves(stage, wild(4), path="/groom/other"), "frizz", floats, TOKENS.uniform, [0.5])
    with pytest.warns(UserWarning) as reported:
        found = read_curves(saved(stage), None)
    assert {name: values.tolist() for name, values in found.maps.items()} == {"clump": [1, 3, 0], "frizz": [0, 0, 0.5]}
    assert any("primvars that are not used: broken" in str(warning.message) for warning in reported)


def test_curves_of_another_type_are_named(new_stage, saved) -> None:
    stage = new_stage()
    UsdGeom.HermiteCurves.Define(stage, "/groom/hermite")
    with pytest.raises(BadInput, match="no visible BasisCurves or NurbsCurves, but HermiteCurves, which are not read"):
        read_curves(saved(stage), None)


def test_body_and_hair_are_read_at_one_time(new_stage, saved) -> None:
    stage = new_stage()
    points = curves(stage, wild(4)).GetPointsAttr()
    mesh = UsdGeom.Mesh.Define(stage, "/body")
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    corners = np.eye(3, dtype=np.float32)
    for time in range(1000, 1006):
        mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(corners + time), time)
    for time in range(1002, 1006):
        points.Set(Vt.Vec3fArray(4, Gf.Vec3f(time)), time)
    path = saved(stage)
    with pytest.warns(UserWarning, match="read at time code 1002, the first at which all"):
        hair, body = read_curves(path, None), read_body(path, None)
    assert hair.time == body.time == 1002.0
    assert (hair.points == 1002).all() and np.array_equal(body.mesh.points, corners + 1002)
    hair, body = read_curves(path, None, 1004.0), read_body(path, None, 1004.0)
    assert (hair.points == 1004).all() and np.array_equal(body.mesh.points, corners + 1004)


def test_takes_guides_only_where_there_is_nothing_else(new_stage, saved) -> None:
    stage, (guide, hair, proxy) = new_stage(), wild(4, 7, 3)
    curves(stage, [guide], path="/groom/guides").CreatePurposeAttr(TOKENS.guide)
    curves(stage, [proxy], path="/groom/proxy").CreatePurposeAttr(TOKENS.proxy)
    np.testing.assert_allclose(read(saved(stage), None)[0], guide, atol=1e-7)
    curves(stage, [hair], path="/groom/hair").CreatePurposeAttr(TOKENS.render)
    np.testing.assert_allclose(read(saved(stage), None)[0], hair, atol=1e-7)
    np.testing.assert_allclose(read(saved(stage), "/groom/guides")[0], guide, atol=1e-7)
    with pytest.raises(BadInput, match="no visible BasisCurves or NurbsCurves at or under /groom/proxy"):
        read(saved(stage), "/groom/proxy")


BROKEN: dict[str, tuple[Callable[[Usd.Stage], object], str]] = {
    "none": (lambda s: UsdGeom.Xform.Define(s, "/groom"), "no visible BasisCurves or NurbsCurves"),
    "empty": (lambda s: curves(s, []), "the curves have no points"),
    "no counts": (lambda s: UsdGeom.BasisCurves.Define(s, "/groom/hair"), "the curves have no points"),
    "counts": (lambda s: curves(s, wild(4)).CreateCurveVertexCountsAttr([5]), "curveVertexCounts sum to 5"),
    "negative": (lambda s: curves(s, wild(4)).CreateCurveVertexCountsAttr([-1, 5]), "curveVertexCounts sum to 4"),
    "one point": (lambda s: curves(s, wild(1, 1)), "curve 0: the curve has 1 points"),
    "closed": (lambda s: curves(s, wild(4), wrap=TOKENS.periodic), "the curve is closed"),
    "short": (lambda s: curves(s, wild(3), wrap=TOKENS.nonperiodic), "the Catmull-Rom curve has 3 points"),
    "short bspline": (lambda s: curves(s, wild(3), TOKENS.bspline, TOKENS.nonperiodic), "the B-spline has 3 points"),
    "short bezier": (lambda s: curves(s, wild(6), TOKENS.bezier), "curve 0: the Bezier curve has 6 points"),
    "basis": (lambda s: curves(s, wild(4), "hermite"), "the basis is hermite"),
}


@pytest.mark.parametrize(("plant", "message"), BROKEN.values(), ids=BROKEN)
def test_invalid_prims_are_refused_with_their_path(new_stage, saved, plant: Callable, message: str) -> None:
    stage = new_stage()
    plant(stage)
    with pytest.raises(BadInput) as caught:
        read(saved(stage), None)
    assert message in str(caught.value) and "given.usda" in str(caught.value)


def test_groups_guides_colours_and_root_uv_are_read(new_stage, saved) -> None:
    stage, types = new_stage(), Sdf.ValueTypeNames
    prim = curves(stage, wild(4, 2))
    primvar(prim, "groom_group_name", types.StringArray, TOKENS.uniform, ["tail", "fringe"])
    primvar(prim, "groom_group_id", types.IntArray, TOKENS.uniform, [7, 3])
    primvar(prim, "groom_guide", types.IntArray, TOKENS.uniform, [0, 1])
    primvar(prim, "groom_root_uv", types.Float2Array, TOKENS.uniform, [Gf.Vec2f(0.1, 0.2), Gf.Vec2f(0.3, 0.4)])
    primvar(prim, "groom_color", types.Float3Array, TOKENS.vertex, [Gf.Vec3f(k, 0, 1) for k in range(6)])
    found = read_curves(saved(stage))
    assert found.groups.tolist() == [1, 0] and found.group_names == ("fringe", "tail")
    assert found.guides.tolist() == [False, True]
    np.testing.assert_allclose(found.root_uv, [[0.1, 0.2], [0.3, 0.4]], rtol=1e-6)
    np.testing.assert_array_equal(found.colours, [[k, 0, 1] for k in range(6)])
    prim.GetPrim().RemoveProperty("primvars:groom_group_name")
    again = read_curves(saved(stage))
    assert again.groups.tolist() == [7, 3] and again.group_names == ()


def test_several_prims_are_groups_and_guides_are_read_on_request(new_stage, saved) -> None:
    stage, (one, two, guide) = new_stage(), wild(4, 7, 3)
    curves(stage, [one], path="/groom/beard")
    curves(stage, [two, one], path="/groom/fringe")
    curves(stage, [guide], path="/groom/guides").CreatePurposeAttr(TOKENS.guide)
    path = saved(stage)
    with pytest.warns(UserWarning, match="purpose guide"):
        found = read_curves(path)
    assert found.groups.tolist() == [0, 1, 1] and found.group_names == ("beard", "fringe") and found.guides is None
    assert read_curves(path, guides=True).guides.tolist() == [False, False, False, True]


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
