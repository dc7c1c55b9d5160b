"""Bodies as they are prepared: units, axes, joints, and the scalp."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.bust import build_bust
from hairpipe.body.preparation import drop_unused, prepare, transform
from hairpipe.body.scalp import AZIMUTHS, Scalp, height_above, interpolate_hairline, paint_scalp, smooth_step
from hairpipe.body.skinning import skin
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import Z_UP
from hairpipe.values import Body, Mesh, Skeleton
from tests.body.test_skinning import rich_body, rich_pose

DEFAULTS = {"unit": 1.0, "up": "y", "joint": "head", "scalp": None}


def make_body(rigged: bool = True) -> Body:
    """A tetrahedron of 1 m, and a vertex that no triangle uses."""
    points = np.array([[0.0, 0, 0], [9.0, 9.0, 9.0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    triangles = np.array([[0, 3, 2], [0, 2, 4], [0, 4, 3], [2, 3, 4]], np.int32)
    rest = np.tile(np.eye(4), (2, 1, 1))
    rest[1, :3, 3] = (0.1, 0.2, 0.9)
    skeleton = Skeleton(("hips", "head"), np.array([-1, 0], np.int32), rest, rest[:, :3, 3] + 0.1)
    if not rigged:
        skeleton = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
    count = 2 if rigged else 0
    weights = np.tile([0.25, 0.75][:count], (5, 1))
    joints = np.tile(np.array([0, 1][:count], np.int32), (5, 1))
    return Body(Mesh(points, triangles), skeleton, joints, weights, {"paint": np.arange(5.0) / 5.0})


def test_stray_vertices_are_dropped_with_all_they_carry():
    body = prepare(make_body(), **DEFAULTS)
    np.testing.assert_array_equal(body.mesh.points, make_body().mesh.points[[0, 2, 3, 4]])
    np.testing.assert_array_equal(body.mesh.triangles, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    np.testing.assert_array_equal(body.maps["paint"], [0.0, 0.4, 0.6, 0.8])
    assert body.weights.shape == body.joints.shape == (4, 2)


def test_weights_that_are_nothing_all_down_are_dropped():
    body = replace(make_body(), weights=np.tile([0.0, 1.0], (5, 1)))
    np.testing.assert_array_equal(prepare(body, **DEFAULTS).joints, [[1]] * 4)


def test_units_scale_everything_but_directions():
    body = prepare(make_body(), **{**DEFAULTS, "unit": 0.1})
    np.testing.assert_allclose(body.mesh.points[1], [0.1, 0.0, 0.0])
    np.testing.assert_allclose(body.skeleton.rest[1, :3, 3], [0.01, 0.02, 0.09])
    np.testing.assert_allclose(body.skeleton.rest[1, :3, :3], np.eye(3))
    np.testing.assert_allclose(body.skeleton.tips[1], [0.02, 0.03, 0.10])


def test_z_up_is_turned_and_still_faces_the_viewer():
    body = prepare(make_body(), **{**DEFAULTS, "up": "z"})
    np.testing.assert_allclose(body.mesh.points[3], [0.0, 1.0, 0.0])  # what was up
    np.testing.assert_allclose(body.mesh.points[2], [0.0, 0.0, -1.0])  # behind the face, which looks along -Y
    assert np.linalg.det(body.skeleton.rest[0, :3, :3]) == pytest.approx(1.0)


def test_a_body_in_other_units_and_axes_is_skinned_alike():
    """A scale and a turn of the world commute with blend shapes, joints and dual quaternions."""
    body, matrix = rich_body(), 0.01 * Z_UP
    body = replace(body, mesh=replace(body.mesh, triangles=np.array([[3, 6, 7], [8, 9, 14]], np.int32)))
    pose = rich_pose(body, 0.6)
    turn = np.eye(4)
    turn[:3, :3] = Z_UP
    transforms = turn @ pose.transforms
    transforms[:, :3, 3] *= 0.01
    moved = skin(transform(drop_unused(body), matrix), replace(pose, transforms=transforms))
    np.testing.assert_allclose(moved.points, skin(body, pose).points[[3, 6, 7, 8, 9, 14]] @ matrix.T, atol=1e-12)


def test_transform_keeps_the_body_on_its_joints():
    """What a joint sees of a vertex does not change when both are turned."""
    body, matrix = make_body(), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    turned = transform(body, matrix)
    seen = [(p.skeleton.rest[1, :3, :3].T @ (p.mesh.points - p.skeleton.rest[1, :3, 3]).T) for p in (body, turned)]
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-12)


def test_a_body_without_a_skeleton_gets_one_joint():
    body = prepare(make_body(rigged=False), **{**DEFAULTS, "joint": "Head"})
    assert body.skeleton.names == ("Head",)
    np.testing.assert_allclose(body.skeleton.rest[0, :3, 3], [0.25, 0.25, 0.25])
    np.testing.assert_array_equal(body.weights, np.ones((4, 1)))
    assert body.skeleton.tips[0, 1] == 1.0


def test_the_one_joint_of_a_skeleton_keeps_its_name():
    body, skeleton = make_body(), make_body().skeleton
    single = Skeleton(("hips",), skeleton.parents[:1], skeleton.rest[:1], skeleton.tips[:1])
    body = replace(body, skeleton=single, joints=body.joints[:, :1], weights=np.ones((5, 1)))
    assert prepare(body, **DEFAULTS).skeleton.names == ("hips",)


@pytest.mark.parametrize(("unit", "size"), [(10.0, "10 m"), (0.001, "0.001 m")])
def test_implausible_sizes_are_reported(unit, size):
    with pytest.warns(UserWarning, match=f"{size} large: is unit = "):
        prepare(make_body(), **{**DEFAULTS, "unit": unit})


def test_people_pass_without_a_word():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        prepare(make_body(), **DEFAULTS)


def test_a_scalp_is_painted_on_request():
    rule = Scalp(joint="head", up=-0.5, forward=0.0)
    assert "scalp" not in prepare(make_body(), **DEFAULTS).maps
    assert set(prepare(make_body(), **{**DEFAULTS, "scalp": rule}).maps) == {"paint", "scalp"}


def broken(**mesh) -> Body:
    body = make_body()
    return replace(body, mesh=replace(body.mesh, **mesh))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (broken(triangles=np.zeros((0, 3), np.int32)), "no triangles"),
        (broken(triangles=np.array([[0, 1, 5]], np.int32)), "vertex that does not exist"),
        (broken(triangles=np.array([[0, 1, -1]], np.int32)), "vertex that does not exist"),
        (broken(points=np.full((5, 3), np.nan)), "positions are not all finite"),
        (replace(make_body(), weights=np.full((5, 2), np.inf)), "weights are not all finite"),
    ],
)
def test_broken_meshes_are_refused(body, message):
    with pytest.raises(BadInput, match=message):
        prepare(body, **DEFAULTS)


RULE = Scalp(joint="head", up=0.1, forward=0.0, edge=4.0)


def direction(azimuth: float, elevation: float) -> np.ndarray:
    a, e = np.radians([azimuth, elevation])
    return np.array([[np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)]])


def make_head(points: np.ndarray, weights: np.ndarray) -> Body:
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
    np.testing.assert_allclose(paint_scalp(make_head(top, weights), RULE), [1.0, 0.0, 1.0])


def test_a_missing_joint_is_named():
    with pytest.raises(BadInput, match=r"skull.*hips, head"):
        paint_scalp(make_head(np.zeros((1, 3)), np.array([[0.0, 1.0]])), Scalp(joint="skull"))


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
    body = make_head(top, np.array([[0.0, 1.0], [1.0, 0.0]]))
    body = replace(body, skeleton=replace(body.skeleton, names=names))
    np.testing.assert_allclose(paint_scalp(body, replace(RULE, joint=Scalp().joint)), [1.0, 0.0])


def test_point_between_the_ears_can_be_given():
    points = np.array([[0.0, 1.4, 0.0], [0.0, 2.3, 0.0], [0.0, 1.9, 0.0]])
    body = make_head(points, np.tile([0.0, 1.0], (3, 1)))
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
