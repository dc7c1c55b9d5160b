"""Animated meshes of stages that pxr wrote, against analytic motion and OpenUSD's own baking of skeletons."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdUtils, Vt

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.usd.meshes import MovingMeshes, read_moving

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
OMEGA = 1.5
FRAMES = range(1001, 1007)


def vectors(points: np.ndarray) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32))


def add_square(stage: Usd.Stage, path: str, points: np.ndarray = SQUARE) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreatePointsAttr(vectors(points))
    return mesh


def bent(seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Points that accelerate, and their velocities: a parabola of time."""
    away = np.array([0.0, 0.1, 0.5, 1.0])[:, None] * (1.0, 2.0, -3.0)
    return SQUARE + away * seconds**2, 2.0 * away * seconds


def start(path: Path, fps: float = 24.0, up: str = "Y", scale: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, scale)
    stage.SetTimeCodesPerSecond(fps)
    return stage


@pytest.fixture
def bending(tmp_path: Path) -> Path:
    """A square that accelerates, sampled at every frame."""
    stage = start(tmp_path / "bent.usda")
    mesh = add_square(stage, "/bent")
    for frame in FRAMES:
        mesh.GetPointsAttr().Set(vectors(bent((frame - 1001) / 24)[0]), frame)
    stage.Save()
    return tmp_path / "bent.usda"


def at(frame: float, **more) -> Instant:
    return Instant(1001, (frame - 1001) / 24, **more)


@pytest.mark.parametrize("frame", [1001, 1003, 1003.4, 1006])
def test_time_samples_give_points_and_velocities(bending, frame):
    mesh, _ = read_moving(bending, None, at(frame))
    points, velocities = bent((frame - 1001) / 24)
    np.testing.assert_allclose(mesh.points, points, atol=1e-6)
    np.testing.assert_allclose(mesh.velocities, velocities, atol=2e-5)


def test_a_moving_parent_moves_and_scales_the_points(tmp_path):
    stage = start(tmp_path / "turn.usda", up="Z", scale=0.01)
    parent = UsdGeom.Xform.Define(stage, "/turn")
    turn = parent.AddRotateZOp()
    add_square(stage, "/turn/square", 100 * SQUARE)
    for sample in range(4 * 6):
        turn.Set(float(np.degrees(OMEGA * sample / 96)), 1001 + sample / 4)
    stage.Save()
    mesh, _ = read_moving(tmp_path / "turn.usda", None, at(1004))
    angle = OMEGA * 3 / 24
    x, y = SQUARE[:, 0], SQUARE[:, 1]
    turned = np.stack([np.cos(angle) * x - np.sin(angle) * y, 0 * x, -np.sin(angle) * x - np.cos(angle) * y], axis=1)
    np.testing.assert_allclose(mesh.points, turned, atol=1e-6)
    np.testing.assert_allclose(mesh.velocities, np.cross([0, OMEGA, 0], turned), atol=3e-4)


def test_velocities_of_the_file_are_used_and_compared(bending):
    stage = Usd.Stage.Open(str(bending))
    mesh = UsdGeom.Mesh.Get(stage, "/bent")
    for frame in FRAMES:
        mesh.CreateVelocitiesAttr().Set(vectors(1.1 * bent((frame - 1001) / 24)[1]), frame)
    stage.Save()
    truth = bent(3 / 24)[1]
    np.testing.assert_allclose(read_moving(bending, None, at(1004))[0].velocities, 1.1 * truth, atol=1e-6)
    own = read_moving(bending, None, at(1004, velocities="samples"))[0].velocities
    np.testing.assert_allclose(own, truth, atol=2e-5)
    for frame in FRAMES:
        mesh.GetVelocitiesAttr().Set(vectors(bent((frame - 1001) / 24)[1] / 24), frame)
    stage.Save()
    with pytest.warns(UserWarning, match="units per frame"):
        read_moving(bending, None, at(1004))


def test_velocities_at_a_cut_do_not_see_the_jump(bending):
    stage = Usd.Stage.Open(str(bending))
    points = UsdGeom.Mesh.Get(stage, "/bent").GetPointsAttr()
    for frame in (1004, 1005, 1006):
        points.Set(vectors(bent((frame - 1001) / 24)[0] + 100), frame)
    stage.Save()
    cuts = ((2 / 24, 3 / 24),)
    for frame in (1003, 1004):
        mesh, _ = read_moving(bending, None, at(frame, cuts=cuts))
        np.testing.assert_allclose(mesh.velocities, bent((frame - 1001) / 24)[1], atol=1e-3)


def test_value_clips_are_read(tmp_path):
    files = []
    for frame in FRAMES:
        clip = start(tmp_path / f"clip.{frame}.usda")
        clip.SetStartTimeCode(frame)
        clip.SetEndTimeCode(frame)
        add_square(clip, "/bent").GetPointsAttr().Set(vectors(bent((frame - 1001) / 24)[0]), frame)
        clip.GetAttributeAtPath("/bent.points").ClearDefault()
        clip.Save()
        files.append(clip.GetRootLayer().identifier)
    root = Sdf.Layer.CreateNew(str(tmp_path / "shot.usda"))
    assert UsdUtils.StitchClips(root, files, "/bent", FRAMES[0], FRAMES[-1])
    root.Save()
    UsdGeom.SetStageMetersPerUnit(Usd.Stage.Open(root), 1.0)
    root.Save()
    mesh, _ = read_moving(tmp_path / "shot.usda", None, at(1003))
    points, velocities = bent(2 / 24)
    np.testing.assert_allclose(mesh.points, points, atol=1e-6)
    np.testing.assert_allclose(mesh.velocities, velocities, atol=2e-5)


def test_meshes_are_joined_or_picked_by_a_pattern(tmp_path):
    stage = start(tmp_path / "two.usda")
    add_square(stage, "/shot/body")
    add_square(stage, "/shot/garment/sleeve", SQUARE + 5)
    stage.Save()
    points = {
        group: read_moving(tmp_path / "two.usda", group, at(1001))[0].points
        for group in (None, "/shot/body", "*/garment")
    }
    assert len(points[None]) == 8
    np.testing.assert_array_equal(points["/shot/body"], SQUARE)
    np.testing.assert_array_equal(points["*/garment"], SQUARE + 5)
    with pytest.raises(BadInput, match=r"no visible Mesh at or under \*lash"):
        read_moving(tmp_path / "two.usda", "*lash*", at(1001))


def test_changed_polygons_are_refused_by_time_code(bending):
    stage = Usd.Stage.Open(str(bending))
    corners = UsdGeom.Mesh.Get(stage, "/bent").GetFaceVertexIndicesAttr()
    corners.Set([0, 1, 2, 3], 1001)
    corners.Set([3, 1, 2, 0], 1004)
    stage.Save()
    read_moving(bending, None, at(1001))
    with pytest.raises(BadInput, match=r"bent.usda /bent at time code 1004: the polygons have changed .*1001"):
        read_moving(bending, None, at(1003))


def test_a_point_instancer_is_refused_by_name(bending):
    stage = Usd.Stage.Open(str(bending))
    UsdGeom.PointInstancer.Define(stage, "/scatter")
    add_square(stage, "/scatter/proto")
    stage.Save()
    with pytest.raises(BadInput, match=r"/scatter: is a PointInstancer"):
        read_moving(bending, None, at(1001))
    assert len(read_moving(bending, "/bent", at(1001))[0].points) == 4


def rotation(axis: tuple[float, float, float], degrees: float) -> Gf.Quatf:
    return Gf.Quatf(Gf.Rotation(Gf.Vec3d(*axis), degrees).GetQuat())


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A bent and twisted arm on two joints, with two blend shapes, under a moving parent."""
    stage = start(tmp_path / "arm.usda")
    root = UsdSkel.Root.Define(stage, "/arm")
    move = root.AddTranslateOp()
    skeleton = UsdSkel.Skeleton.Define(stage, "/arm/skeleton")
    skeleton.CreateJointsAttr(["upper", "upper/lower"])
    elbow = Gf.Matrix4d().SetTranslate(Gf.Vec3d(0, 1, 0))
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1), elbow])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1), elbow])
    animation = UsdSkel.Animation.Define(stage, "/arm/animation")
    animation.CreateJointsAttr(["upper", "upper/lower"])
    animation.CreateBlendShapesAttr(["bulge", "thin"])
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    heights = np.linspace(0, 2, 9)
    points = np.array([[x, y, z] for y in heights for x, z in ((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1))])
    around = [(0, 1), (1, 2), (2, 3), (3, 0)]
    faces = [[4 * k + a, 4 * k + b, 4 * k + 4 + b, 4 * k + 4 + a] for k in range(8) for a, b in around]
    skin = UsdGeom.Mesh.Define(stage, "/arm/skin")
    skin.CreatePointsAttr(vectors(points))
    skin.CreateFaceVertexCountsAttr([4] * len(faces))
    skin.CreateFaceVertexIndicesAttr(np.array(faces).ravel().tolist())
    binding = UsdSkel.BindingAPI.Apply(skin.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    share = np.clip(points[:, 1] - 0.5, 0, 1).astype(np.float32)
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * len(points))
    binding.CreateJointWeightsPrimvar(False, 2).Set(np.stack([1 - share, share], axis=1).ravel().tolist())
    shapes = []
    for name, offsets, indices in (
        ("bulge", 0.3 * points * (1, 0, 1), None),
        ("thin", -0.5 * points[8:12], range(8, 12)),
    ):
        shape = UsdSkel.BlendShape.Define(stage, f"/arm/skin/{name}")
        shape.CreateOffsetsAttr(vectors(offsets))
        if indices:
            shape.CreatePointIndicesAttr(list(indices))
        shapes.append(shape)
    between = shapes[0].CreateInbetween("half")
    between.SetWeight(0.5)
    between.SetOffsets(vectors(0.4 * points * (1, 0, 1)))
    binding.CreateBlendShapesAttr(["bulge", "thin"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath() for shape in shapes])
    for frame in FRAMES:
        angle = 17.0 * (frame - 1001)
        move.Set(Gf.Vec3d(0.1 * angle, 0, 0), frame)
        animation.GetTranslationsAttr().Set([Gf.Vec3f(0), Gf.Vec3f(0, 1, 0)], frame)
        animation.GetRotationsAttr().Set([rotation((0, 1, 0), angle), rotation((1, 0, 1), 1.3 * angle)], frame)
        animation.GetScalesAttr().Set([Gf.Vec3h(1), Gf.Vec3h(1, 1.25, 1)], frame)
        animation.GetBlendShapeWeightsAttr().Set([0.18 * (frame - 1001), 1.0 - 0.1 * (frame - 1001)], frame)
    stage.Save()
    return tmp_path / "arm.usda"


def baked(path: Path) -> Usd.Stage:
    """OpenUSD's own baking: the points of the mesh at all frames."""
    stage = Usd.Stage.Open(str(path))
    assert UsdSkel.BakeSkinning(UsdSkel.Root.Get(stage, "/arm"), Gf.Interval(FRAMES[0], FRAMES[-1]))
    return stage


@pytest.mark.parametrize("method", ["classicLinear", "dualQuaternion"])
def test_skeletons_and_blend_shapes_are_those_of_openusd(arm, method):
    stage = Usd.Stage.Open(str(arm))
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/arm/skin")).CreateSkinningMethodAttr().Set(method)
    stage.Save()
    found = [read_moving(arm, None, at(frame))[0].points for frame in FRAMES]
    truth = baked(arm)
    for frame, points in zip(FRAMES, found, strict=True):
        mesh = UsdGeom.Mesh.Get(truth, "/arm/skin")
        matrix = np.array(UsdGeom.Xformable(mesh).ComputeLocalToWorldTransform(frame))
        world = np.array(mesh.GetPointsAttr().Get(frame)) @ matrix[:3, :3] + matrix[3, :3]
        np.testing.assert_allclose(points, world, atol=1e-6)
    assert np.abs(np.diff(found, axis=0)).max() > 0.3


def test_a_face_of_blend_shapes_alone_moves(arm):
    stage = Usd.Stage.Open(str(arm))
    for name in ("jointIndices", "jointWeights"):
        stage.GetPrimAtPath("/arm/skin").RemoveProperty(f"primvars:skel:{name}")
    stage.Save()
    moved = [read_moving(arm, None, at(frame))[0].points for frame in (1001, 1004)]
    assert np.ptp(moved[1][:4, 0]) > 1.1 * np.ptp(moved[0][:4, 0])


def test_no_more_than_four_samples_are_read_and_one_is_in_memory(bending):
    from hairpipe.formats.animated_meshes import read_at

    source = MovingMeshes(bending, None)
    alive, most, count = 0, 0, 0

    class Counted(np.ndarray):
        def __del__(self) -> None:
            nonlocal alive
            alive -= self.base is not None and self.shape[-1:] == (3,)

    original = source.sample

    def sample(index: int) -> list:
        nonlocal alive, most, count
        (points, velocities), *_ = original(index)
        alive, count = alive + 1, count + 1
        most = max(most, alive)
        return [(points.view(Counted), velocities)]

    source.sample = sample
    for frame in np.linspace(1001, 1006, 41):
        count = 0
        read_at(source, at(frame))
        assert count <= 4
    assert most == 1


def test_two_keys_of_a_parent_turn_along_an_arc(tmp_path):
    stage = start(tmp_path / "turn.usda")
    turn = UsdGeom.Xform.Define(stage, "/turn").AddRotateZOp()
    add_square(stage, "/turn/square")
    turn.Set(0.0, 1001)
    turn.Set(720.0, 1021)
    stage.Save()
    mesh, _ = read_moving(tmp_path / "turn.usda", None, at(1006))
    np.testing.assert_allclose(mesh.points, SQUARE * (-1, -1, 1), atol=1e-6)
