import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.bust import build_bust
from hairpipe.body.preparation import prepare
from hairpipe.body.scalp import AZIMUTHS, Scalp, height_above, interpolate_hairline, paint_scalp, smooth_step
from hairpipe.errors import BadInput
from hairpipe.values import Body, Mesh, Skeleton

RULE = Scalp(joint="head", up=0.1, forward=0.0, edge=4.0)


def direction(azimuth: float, elevation: float) -> np.ndarray:
    a, e = np.radians([azimuth, elevation])
    return np.array([[np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)]])


def make_body(points: np.ndarray, weights: np.ndarray) -> Body:
    rest = np.tile(np.eye(4), (2, 1, 1))
    rest[1, :3, 3] = (0.0, 1.0, 0.0)
    skeleton = Skeleton(("hips", "head"), np.array([-1, 0], np.int32), rest, rest[:, :3, 3])
    mesh = Mesh(points, np.zeros((0, 3), np.int32))
    return Body(mesh, skeleton, np.tile(np.array([0, 1], np.int32), (len(points), 1)), weights)


def test_line_passes_through_given_points():
    reported = [RULE.front, RULE.temple, RULE.sideburn, RULE.ear, RULE.behind, RULE.nape]
    np.testing.assert_allclose(interpolate_hairline(RULE, np.array(AZIMUTHS)), reported, atol=1e-12)


def test_the_line_stays_between_its_knots():
    azimuth = np.linspace(0.0, 180.0, 721)
    line = interpolate_hairline(RULE, azimuth)
    assert line.max() <= max(RULE.front, RULE.temple, RULE.ear) and line.min() >= RULE.nape
    assert np.abs(np.diff(line)).max() < 1.0


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize(("above", "value"), [(-2.1, 0.0), (0.0, 0.5), (2.1, 1.0)])
def test_hair_begins_at_the_line_on_both_sides(azimuth, above, value):
    line = interpolate_hairline(RULE, np.array([azimuth]))[0]
    for side in (azimuth, -azimuth):
        assert height_above(RULE, direction(side, line + above))[0] == pytest.approx(value, abs=1e-6)


def test_only_what_the_head_carries_is_scalp():
    top = np.array([[0.0, 1.4, 0.0]] * 3)
    weights = np.array([[0.0, 1.0], [1.0, 0.0], [0.5, 0.5]])
    np.testing.assert_allclose(paint_scalp(make_body(top, weights), RULE), [1.0, 0.0, 1.0])


def test_a_missing_joint_is_named():
    with pytest.raises(BadInput, match=r"skull.*hips, head"):
        paint_scalp(make_body(np.zeros((1, 3)), np.array([[0.0, 1.0]])), Scalp(joint="skull"))


@pytest.mark.parametrize(
    "names",
    [
        ("mixamorig:Neck", "mixamorig:Head"),
        ("J_Bip_C_Neck", "J_Bip_C_Head"),
        ("DEF-spine.005", "DEF-spine.006"),
        ("DEF_spine_005", "DEF_spine_006"),
        ("Bip01 Neck", "Bip01 Head"),
        ("C_neck", "C_Head"),
    ],
)
def test_the_head_of_usual_rigs_is_found_by_default(names):
    top = np.array([[0.0, 1.4, 0.0]] * 2)
    body = make_body(top, np.array([[0.0, 1.0], [1.0, 0.0]]))
    body = replace(body, skeleton=replace(body.skeleton, names=names))
    np.testing.assert_allclose(paint_scalp(body, replace(RULE, joint=Scalp().joint)), [1.0, 0.0])


def test_point_between_the_ears_can_be_given():
    points = np.array([[0.0, 1.4, 0.0], [0.0, 2.3, 0.0], [0.0, 1.9, 0.0]])
    body = make_body(points, np.tile([0.0, 1.0], (3, 1)))
    np.testing.assert_array_equal(paint_scalp(body, RULE), [1.0, 1.0, 1.0])
    np.testing.assert_array_equal(paint_scalp(body, replace(RULE, at=(0.0, 2.0, 0.0))), [0.0, 1.0, 0.0])


def test_a_bust_without_a_skeleton_gets_its_hairline_about_its_head():
    bust = build_bust()
    rigid = replace(bust, skeleton=Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3))))
    with pytest.warns(UserWarning, match=r"no skeleton .* centred at \(0\.000, .*scalp\.at"):
        painted = prepare(rigid, unit=1.0, up="y", joint="head", scalp=Scalp()).maps["scalp"]
    assert np.mean(np.abs(painted - bust.maps["scalp"]) > 0.5) < 0.02, "as on the bust itself"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        reported = prepare(rigid, unit=1.0, up="y", joint="head", scalp=Scalp(at=(0.0, 0.3, 0.0))).maps["scalp"]
    assert not np.array_equal(reported, painted)


def test_smooth_step_rises_level_at_both_ends():
    t = np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(smooth_step(2.0 * t + 3.0, 3.0, 5.0), [0.0, 0.0, 0.5, 1.0, 1.0])


def test_the_default_hairline_fits_the_makehuman_head(shared):
    from hairpipe.formats.registry import read_body

    folder = shared / "body_makehuman"
    rig = {"skeleton": folder / "default.mhskel", "weights": folder / "default_weights.mhw"}
    body = prepare(read_body(folder / "base.obj", group="body", **rig), unit=0.1, up="y", joint="head", scalp=Scalp())
    points, scalp = body.mesh.points, body.maps["scalp"]
    assert (scalp[points[:, 1] > 0.81] > 0.95).all()
    assert (scalp[(points[:, 2] > 0.13) & (points[:, 1] < 0.77)] == 0.0).all()  # face
    assert (scalp[points[:, 1] < 0.62] == 0.0).all()  # neck and all below
    assert (scalp[(np.abs(points[:, 0]) > 0.078) & (points[:, 1] < 0.73)] < 0.5).all()  # ears
    assert scalp[np.argmin(np.linalg.norm(points - (0.0, 0.72, -0.04), axis=1))] == 1.0  # back of the head
