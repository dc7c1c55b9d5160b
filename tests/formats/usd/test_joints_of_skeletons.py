"""Motion of UsdSkel joints: skin moved by their poses against OpenUSD's own baking, and retargeted to other bodies."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt
from scipy.spatial.transform import Rotation

from hairpipe.body.bust import build_skeleton
from hairpipe.body.skinning import skin
from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.nodes.load_motion import load_motion
from hairpipe.values import Body, Mesh
from tests.formats.usd.test_skeleton import JOINTS, ORIGINS, character, locals_of
from tests.formats.usd.test_skeleton import at as placed

FRAMES = range(1001, 1007)


def animate(stage: Usd.Stage, joints: list[str], local: list[Gf.Matrix4d], turn: dict[str, float]) -> None:
    """Turn joints about Y by so many degrees a frame; the skeleton moves, too."""
    animation = UsdSkel.Animation.Define(stage, "/char/animation")
    animation.CreateJointsAttr(joints)
    skeleton = stage.GetPrimAtPath("/char/skeleton")
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    move = UsdGeom.Xformable(skeleton).AddTranslateOp()
    for frame in FRAMES:
        angles = [turn.get(joint, 0.0) * (frame - FRAMES[0]) for joint in joints]
        turns = [Gf.Matrix4d(Gf.Rotation(Gf.Vec3d(0, 1, 0), angle), Gf.Vec3d(0)) for angle in angles]
        translations, rotations, scales = UsdSkel.DecomposeTransforms(
            Vt.Matrix4dArray([t * m for t, m in zip(turns, local, strict=True)])
        )
        animation.GetTranslationsAttr().Set(translations, frame)
        animation.GetRotationsAttr().Set(rotations, frame)
        animation.GetScalesAttr().Set(Vt.Vec3hArray([Gf.Vec3h(1, 1 + 0.25 * (frame % 2), 1)] * len(scales)), frame)
        move.Set(Gf.Vec3d(0.1 * (frame - FRAMES[0]) ** 2, 0, 0), frame)


@pytest.fixture
def moving(new_stage, saved) -> Path:
    """A character in units of 5 cm with Z up, whose joints turn and stretch."""
    stage = new_stage("Z", 0.05)
    stage.SetTimeCodesPerSecond(24.0)
    character(stage)
    local = locals_of([placed(*origin, turn=10 * n) for n, origin in enumerate(ORIGINS)])
    animate(stage, JOINTS, local, {"hips": 5.0, "hips/spine": -20.0, "hips/spine/head": 35.0})
    return saved(stage)


def posed_by(rest: Body, file: Path) -> dict[int, Mesh]:
    return {frame: skin(rest, load_motion(rest, Time(frame, 24.0), (), file=file)) for frame in FRAMES}


def assert_baked(file: Path, posed: dict[int, Mesh], *names: str, atol: float = 1e-6) -> None:
    """Compare skin with the points of meshes as OpenUSD bakes them."""
    stage = Usd.Stage.Open(str(file))
    assert UsdSkel.BakeSkinning(UsdSkel.Root.Get(stage, "/char"), Gf.Interval(FRAMES[0], FRAMES[-1]))
    for frame, skinned in posed.items():
        baked = []
        for mesh in (UsdGeom.Mesh.Get(stage, f"/char/{name}") for name in names):
            world = mesh.ComputeLocalToWorldTransform(frame)
            baked += [world.Transform(Gf.Vec3d(p)) for p in mesh.GetPointsAttr().Get(frame)]
        np.testing.assert_allclose(skinned.points, 0.05 * np.array(baked)[:, [0, 2, 1]] * (1, 1, -1), atol=atol)


def test_poses_move_the_skin_as_openusd_bakes_it(moving):
    rest = load_body(file=moving)
    posed = posed_by(rest, moving)
    meshes = {frame: load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=moving) for frame in FRAMES}
    for frame in FRAMES:
        np.testing.assert_allclose(posed[frame].points, meshes[frame].points, atol=1e-8)
        np.testing.assert_allclose(posed[frame].velocities, meshes[frame].velocities, atol=1e-6)
    assert_baked(moving, posed, "mesh", atol=1e-7)
    assert np.abs(posed[1006].points - posed[1001].points).max() > 0.02


def add_shapes(stage: Usd.Stage) -> None:
    """Give the character two blend shapes, one of some points with in-betweens, and weights beyond their keys."""
    rng = np.random.default_rng(1)
    mesh = UsdSkel.BindingAPI(stage.GetPrimAtPath("/char/mesh"))
    smile = UsdSkel.BlendShape.Define(stage, "/char/mesh/smile")
    smile.CreatePointIndicesAttr([1, 2, 5, 7])
    smile.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy(rng.normal(size=(4, 3)).astype(np.float32)))
    for name, weight in (("half", 0.5), ("sneer", -0.25)):
        smile.CreateInbetween(name).SetWeight(weight)
        smile.GetInbetween(name).SetOffsets(Vt.Vec3fArray.FromNumpy(rng.normal(size=(4, 3)).astype(np.float32)))
    puff = UsdSkel.BlendShape.Define(stage, "/char/mesh/puff")
    puff.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy(rng.normal(size=(12, 3)).astype(np.float32)))
    mesh.CreateBlendShapesAttr(["smile", "puff"])
    mesh.CreateBlendShapeTargetsRel().SetTargets([smile.GetPath(), puff.GetPath()])
    animation = UsdSkel.Animation.Get(stage, "/char/animation")
    animation.CreateBlendShapesAttr(["puff", "smile"])
    for frame, smiling in zip(FRAMES, (-0.5, -0.1, 0.2, 0.7, 1.0, 1.4), strict=True):
        animation.CreateBlendShapeWeightsAttr().Set([0.1 * (frame - 1003), smiling], frame)


@pytest.mark.parametrize("method", ["classicLinear", "dualQuaternion"])
@pytest.mark.parametrize("bent", [False, True])
def test_poses_carry_blend_shapes_and_methods_as_openusd_bakes_them(moving, method, bent):
    stage = Usd.Stage.Open(str(moving))
    add_shapes(stage)
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/char/mesh")).CreateSkinningMethodAttr(method)
    if bent:  # bound in another pose than the one of rest
        skeleton = UsdSkel.Skeleton.Get(stage, "/char/skeleton")
        skeleton.GetRestTransformsAttr().Set(locals_of([placed(*o, turn=-20 * n) for n, o in enumerate(ORIGINS)]))
    stage.Save()
    rest = load_body(file=moving)
    assert (rest.bound is not None) == bent and (rest.dual is not None) == (method == "dualQuaternion")
    assert_baked(moving, posed_by(rest, moving), "mesh")


def add_brows(stage: Usd.Stage) -> None:
    """Add a copy of the mesh without in-betweens, whose shape has the name of one of the mesh."""
    layer = stage.GetRootLayer()
    assert Sdf.CopySpec(layer, "/char/mesh", layer, "/char/brows")
    brows = UsdSkel.BindingAPI(stage.GetPrimAtPath("/char/brows"))
    shape = UsdSkel.BlendShape.Define(stage, "/char/brows/raise")
    shape.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy(np.random.default_rng(2).normal(size=(12, 3)).astype(np.float32)))
    brows.GetBlendShapesAttr().Set(["smile"])
    brows.GetBlendShapeTargetsRel().SetTargets([shape.GetPath()])


def test_meshes_with_a_shape_of_one_name_move_as_openusd_bakes_them(moving):
    stage = Usd.Stage.Open(str(moving))
    add_shapes(stage)
    add_brows(stage)
    stage.Save()
    rest = load_body(file=moving)
    assert rest.shapes.names == ("smile", "puff") and rest.shapes.meshes.tolist() == [0, 0, 0, 0, 1]
    assert_baked(moving, posed_by(rest, moving), "mesh", "brows")


def test_a_face_of_blend_shapes_alone_follows_the_weights_of_its_own_skeleton(moving):
    stage = Usd.Stage.Open(str(moving))
    add_shapes(stage)
    add_brows(stage)
    layer = stage.GetRootLayer()
    for name in ("skeleton", "animation"):
        assert Sdf.CopySpec(layer, f"/char/{name}", layer, f"/char/face_{name}")
    brows = stage.GetPrimAtPath("/char/brows")
    for name in ("primvars:skel:jointIndices", "primvars:skel:jointWeights", "primvars:skel:geomBindTransform"):
        brows.RemoveProperty(name)
    binding = UsdSkel.BindingAPI(brows)
    binding.GetSkeletonRel().SetTargets(["/char/face_skeleton"])
    binding.GetBlendShapesAttr().Set(["raise"])
    face = UsdSkel.BindingAPI(stage.GetPrimAtPath("/char/face_skeleton"))
    face.GetAnimationSourceRel().SetTargets(["/char/face_animation"])
    animation = UsdSkel.Animation.Get(stage, "/char/face_animation")
    animation.GetBlendShapesAttr().Set(["raise", "none"])
    stage.Save()
    with pytest.warns(UserWarning, match="not bound to a skeleton"):
        rest = load_body(file=moving)
    with pytest.warns(UserWarning, match="without a blend shape of the body: none$"):
        pose = load_motion(rest, Time(1004, 24.0), (), file=moving)
    assert len(pose.transforms) == 4 and rest.shapes.names == ("smile", "puff", "raise")
    np.testing.assert_allclose(pose.weights, [0.7, 0.1, 0.1], atol=1e-7)


def test_blend_shapes_without_a_weight_are_named(moving):
    stage = Usd.Stage.Open(str(moving))
    add_shapes(stage)
    UsdSkel.Animation.Get(stage, "/char/animation").GetBlendShapesAttr().Set(["puff"])
    for frame in FRAMES:
        UsdSkel.Animation.Get(stage, "/char/animation").GetBlendShapeWeightsAttr().Set([0.5], frame)
    stage.Save()
    rest = load_body(file=moving)
    with pytest.warns(UserWarning, match="blend shapes without a weight, which stay at rest: smile$"):
        pose = load_motion(rest, Time(1004, 24.0), (), file=moving)
    np.testing.assert_allclose(pose.weights, [0.0, 0.5], atol=1e-7)


def test_weights_of_another_file_go_by_name(moving, tmp_path):
    stage = Usd.Stage.Open(str(moving))
    add_shapes(stage)
    stage.Save()
    rest = load_body(file=moving)
    other = tmp_path / "other.usda"
    UsdSkel.Animation.Get(stage, "/char/animation").GetBlendShapesAttr().Set(["frown", "smile"])
    stage.GetRootLayer().Export(str(other))
    own = load_motion(rest, Time(1004, 24.0), (), file=moving)
    with pytest.warns(UserWarning, match="weights without a blend shape of the body: frown; puff of the body stay"):
        found = load_motion(rest, Time(1004, 24.0), (), file=other)
    assert rest.shapes.names == ("smile", "puff")
    np.testing.assert_allclose(own.weights, [0.7, 0.1], atol=1e-7)
    np.testing.assert_allclose(found.weights, [0.7, 0.0], atol=1e-7)
    bare = load_body(file=moving, group="/char/mesh")
    with pytest.warns(UserWarning, match="without a blend shape of the body: puff, smile$"):
        load_motion(replace(bare, shapes=None), Time(1004, 24.0), (), file=moving)


def test_a_usd_clip_begins_at_its_first_sample_and_has_a_speed(moving):
    rest = load_body(file=moving)
    now = load_motion(rest, Time(1004, 24.0), (), file=moving)
    later = load_motion(rest, Time(1, 24.0), (), file=moving, at=1, start=3.0 / 24.0)
    slow = load_motion(rest, Time(1007, 24.0), (), file=moving, speed=0.5)
    np.testing.assert_allclose(later.transforms, now.transforms, atol=1e-12)
    np.testing.assert_allclose(slow.transforms, now.transforms, atol=1e-12)
    np.testing.assert_allclose(slow.rates, 0.5 * now.rates, atol=1e-9)


def test_motion_is_retargeted_to_another_body(new_stage, saved):
    own = build_skeleton()
    bust = Body(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)), own, np.zeros((0, 1)), np.zeros((0, 1)))
    paths = list(own.names)
    for joint, parent in enumerate(own.parents):
        paths[joint] = own.names[joint] if parent < 0 else f"{paths[parent]}/{own.names[joint]}"
    stage = new_stage()
    stage.SetTimeCodesPerSecond(24.0)
    UsdSkel.Root.Define(stage, "/char")
    skeleton = UsdSkel.Skeleton.Define(stage, "/char/skeleton")
    world = [Gf.Matrix4d(m.T) for m in own.rest]
    for matrix in world:
        matrix.SetTranslateOnly(1.3 * matrix.ExtractTranslation())
    local = [m if p < 0 else m * world[p].GetInverse() for m, p in zip(world, own.parents.tolist(), strict=True)]
    skeleton.CreateJointsAttr(paths)
    skeleton.CreateBindTransformsAttr(world)
    skeleton.CreateRestTransformsAttr(local)
    animate(stage, paths, local, {paths[own.names.index("head")]: 12.0})
    file = saved(stage)
    with pytest.warns(UserWarning, match="joints at rest are not those of the body, to which the motion is retargeted"):
        load_motion(bust, Time(1004, 24.0), (), file=file)
    head = own.names.index("head")
    for frame in (1001, 1004):
        pose = load_motion(bust, Time(frame, 24.0), (), file=file, skip=0, unit=1.0)
        turn = Rotation.from_matrix(pose.transforms[head, :3, :3] @ own.rest[head, :3, :3].T)
        axis = own.rest[head, :3, 1]
        np.testing.assert_allclose(turn.as_rotvec(), np.radians(12.0 * (frame - 1001)) * axis, atol=1e-6)


def test_skeletons_without_motion_are_refused(new_stage, saved):
    stage = new_stage()
    character(stage)
    file = saved(stage)
    rest = load_body(file=file)
    with pytest.raises(BadInput, match=r"/char/skeleton: no animation moves the joints \(a Skeleton whose"):
        load_motion(rest, Time(1001, 24.0), (), file=file)
    with pytest.raises(BadInput, match=r"clip: the format has no clips"):
        load_motion(rest, Time(1001, 24.0), (), file=file, clip="walk")
    with pytest.raises(BadInput, match=r"a BVH file has one clip \(no clip and no group\)"):
        load_motion(rest, Time(1001, 24.0), (), file=Path("a.bvh"), group="/char")
    stage = new_stage(name="walk.usda")
    UsdSkel.Animation.Define(stage, "/walk").CreateJointsAttr(JOINTS)
    with pytest.raises(BadInput, match=r"walk.usda /walk: the animation has no Skeleton, so that its joints at rest"):
        load_motion(rest, Time(1001, 24.0), (), file=saved(stage))
    stage = new_stage(name="box.usda")
    mesh = UsdGeom.Mesh.Define(stage, "/box")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    with pytest.raises(BadInput, match="no mesh is bound to a Skeleton"):
        load_motion(rest, Time(1001, 24.0), (), file=saved(stage))
