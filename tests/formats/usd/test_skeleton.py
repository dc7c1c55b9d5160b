"""UsdSkel bodies rest, bend and move as OpenUSD itself bends them, and their motion is retargeted."""

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
from hairpipe.formats.usd.meshes import read_body
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.nodes.load_motion import load_motion
from hairpipe.values import Body, Mesh

JOINTS = ["hips", "hips/spine", "hips/spine/head", "hips/spine/tail"]
ORIGINS = [(0, 1, 0), (0, 2, 0), (0, 4, 0), (1, 2, 0)]
PLACE = Gf.Matrix4d(Gf.Rotation(Gf.Vec3d(1, 2, 3), 40), Gf.Vec3d(7, -3, 2))
N = 12


def at(*origin: float, turn: float = 0.0) -> Gf.Matrix4d:
    return Gf.Matrix4d(Gf.Rotation(Gf.Vec3d(0, 0, 1), turn), Gf.Vec3d(*origin))


def locals_of(world: list[Gf.Matrix4d]) -> list[Gf.Matrix4d]:
    parents = [None, 0, 1, 1]
    return [m if p is None else m * world[p].GetInverse() for m, p in zip(world, parents, strict=True)]


def character(stage: Usd.Stage, rest: list[Gf.Matrix4d] | None = None) -> UsdGeom.Mesh:
    """A mesh of 12 vertices on four joints, each vertex on two of them; the skeleton stands away from the origin."""
    root = UsdSkel.Root.Define(stage, "/char")
    root.AddTransformOp().Set(PLACE)
    skeleton = UsdSkel.Skeleton.Define(stage, "/char/skeleton")
    bind = [at(*origin, turn=10 * n) for n, origin in enumerate(ORIGINS)]
    skeleton.CreateJointsAttr(JOINTS)
    skeleton.CreateBindTransformsAttr(bind)
    skeleton.CreateRestTransformsAttr(locals_of(bind) if rest is None else rest)
    mesh = UsdGeom.Mesh.Define(stage, "/char/mesh")
    points = np.random.default_rng(0).random((N, 3)).astype(np.float32) * 4
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr([3] * (N - 2))
    mesh.CreateFaceVertexIndicesAttr([i for n in range(N - 2) for i in (n, n + 1, n + 2)])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    UsdSkel.BindingAPI.Apply(root.GetPrim())
    joints = np.stack([np.arange(N) % 4, np.arange(N) // 4], axis=1)
    binding.CreateJointIndicesPrimvar(False, 2).Set([int(j) for j in joints.ravel()])
    binding.CreateJointWeightsPrimvar(False, 2).Set([0.75, 0.25] * N)
    binding.CreateGeomBindTransformAttr(at(0.5, 0.25, 0, turn=5))
    return mesh


def baked(stage: Usd.Stage, pose: list[Gf.Matrix4d]) -> np.ndarray:
    """World positions after UsdSkel's own skinning, with the joints at local transforms."""
    animation = UsdSkel.Animation.Define(stage, "/char/animation")
    animation.CreateJointsAttr(JOINTS)
    animation.SetTransforms(Vt.Matrix4dArray(pose))
    binding = UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/char/skeleton"))
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    assert UsdSkel.BakeSkinning(stage.Traverse())
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/char/mesh"))
    world = mesh.ComputeLocalToWorldTransform(0)
    return np.array([world.Transform(Gf.Vec3d(p)) for p in mesh.GetPointsAttr().Get(0)])


def y_up(points: np.ndarray) -> np.ndarray:
    return 0.01 * np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)


TURNED = locals_of([at(*o, turn=-20 * n) for n, o in enumerate(ORIGINS)])


@pytest.fixture
def stage(new_stage) -> Usd.Stage:
    """A character in metres, Y up."""
    stage = new_stage()
    character(stage)
    return stage


def prim_of(stage: Usd.Stage, name: str = "mesh") -> Usd.Prim:
    return stage.GetPrimAtPath(f"/char/{name}")


def binding_of(stage: Usd.Stage) -> UsdSkel.BindingAPI:
    return UsdSkel.BindingAPI(prim_of(stage))


def remove(stage: Usd.Stage, *names: str, of: str = "mesh") -> None:
    for name in names:
        prim_of(stage, of).RemoveProperty(name)


def rest_of(stage: Usd.Stage) -> list[Gf.Matrix4d]:
    return [Gf.Matrix4d(m) for m in prim_of(stage, "skeleton").GetAttribute("restTransforms").Get()]


@pytest.mark.parametrize("rest", [None, TURNED])
def test_rests_where_usdskel_puts_it(new_stage, saved, rest) -> None:
    stage = new_stage("Z", 0.01)
    character(stage, rest)
    body = read_body(saved(stage), None)
    np.testing.assert_allclose(body.mesh.points, y_up(baked(stage, rest_of(stage))), atol=2e-8)


def test_dual_quaternions_are_read_at_rest_and_marked_where_they_bend(new_stage, saved) -> None:
    stage = new_stage("Z", 0.01)
    UsdSkel.BindingAPI(character(stage, TURNED)).CreateSkinningMethodAttr("dualQuaternion")
    body = read_body(saved(stage), None)
    np.testing.assert_array_equal(body.dual.vertices, np.flatnonzero(body.joints[:, 0] != body.joints[:, 1]))
    binding_of(stage).GetJointIndicesPrimvar().Set([n % 4 for n in range(N) for _ in range(2)])
    assert read_body(saved(stage), None).dual is None, "of one joint"
    binding_of(stage).GetJointIndicesPrimvar().Set([n for v in range(N) for n in (v % 4, v // 4)])
    np.testing.assert_allclose(body.mesh.points, y_up(baked(stage, TURNED)), atol=2e-8)


def test_joints_have_names_parents_origins_and_tips(new_stage, saved) -> None:
    stage = new_stage("Z", 0.01)
    character(stage)
    skeleton = read_body(saved(stage), None).skeleton
    assert skeleton.names == ("hips", "spine", "head", "tail")
    assert skeleton.parents.tolist() == [-1, 0, 1, 1] and skeleton.parents.dtype == np.int32
    origins = y_up(np.array([PLACE.Transform(Gf.Vec3d(*o)) for o in ORIGINS]))
    np.testing.assert_allclose(skeleton.rest[:, :3, 3], origins, atol=1e-12)
    rotations = skeleton.rest[:, :3, :3]
    np.testing.assert_allclose(rotations @ rotations.transpose(0, 2, 1), np.tile(np.eye(3), (4, 1, 1)), atol=1e-12)
    _, spine, head, tail = origins
    expected = [spine, (head + tail) / 2, 2 * head - spine, 2 * tail - spine]
    np.testing.assert_allclose(skeleton.tips, expected, atol=1e-12)


def test_leaves_of_one_name_keep_their_paths(stage, saved) -> None:
    prim_of(stage, "skeleton").GetAttribute("joints").Set(["a", "a/b", "a/b/c", "a/b/c/b"])
    assert read_body(saved(stage), None).skeleton.names == ("a", "a/b", "c", "a/b/c/b")


def test_weights_of_any_sum_rest_where_those_of_sum_1_do(new_stage, saved) -> None:
    """Weights are normalised; a vertex without weights follows the first joint."""
    joints, weights = np.stack([np.arange(N) % 4, np.arange(N) // 4], axis=1), np.tile([0.75, 0.25], (N, 1))
    joints[3], bodies = 0, []
    rest = locals_of([at(*o, turn=-20 * (n + 1)) for n, o in enumerate(ORIGINS)])
    for scale, bare in ((1.0, (1.0, 0.0)), (2.0, (0.0, 0.0))):
        stage = new_stage(name=f"{scale}.usda")
        binding = UsdSkel.BindingAPI(character(stage, rest))
        weights[3] = bare
        binding.GetJointIndicesPrimvar().Set(joints.ravel().tolist())
        binding.GetJointWeightsPrimvar().Set((scale * weights).ravel().tolist())
        bodies.append(read_body(saved(stage), None))
        np.testing.assert_allclose(bodies[-1].weights[[0, 3]], [[0.75, 0.25], [1, 0]])
        np.testing.assert_allclose(bodies[-1].weights.sum(axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(bodies[1].mesh.points, bodies[0].mesh.points, atol=1e-5)
    weights[3] = (1.0, 0.0)
    binding.GetJointWeightsPrimvar().Set(weights.ravel().tolist())
    np.testing.assert_allclose(bodies[1].mesh.points, baked(stage, rest_of(stage)), atol=1e-5)


def smile(stage: Usd.Stage) -> UsdSkel.BlendShape:
    """A blend shape of all points of the character."""
    shape = UsdSkel.BlendShape.Define(stage, "/char/mesh/smile")
    shape.CreateOffsetsAttr([Gf.Vec3f(0, 1, 0)] * N)
    binding_of(stage).CreateBlendShapesAttr(["smile"])
    binding_of(stage).CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    return shape


def test_a_face_whose_skeleton_has_no_joints_keeps_its_shapes(stage, saved) -> None:
    """The pose of such a file is that of rest, with its weights."""
    smile(stage)
    remove(stage, *(f"primvars:skel:{name}" for name in ("jointIndices", "jointWeights", "geomBindTransform")))
    remove(stage, "joints", "bindTransforms", "restTransforms", of="skeleton")
    animation = UsdSkel.Animation.Define(stage, "/char/animation")
    animation.CreateBlendShapesAttr(["smile"])
    for frame, weight in ((1001, 0.0), (1005, 1.0)):
        animation.CreateBlendShapeWeightsAttr().Set([weight], frame)
    skeleton = UsdSkel.BindingAPI.Apply(prim_of(stage, "skeleton"))
    skeleton.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    file = saved(stage)
    body = load_body(file=file)
    assert body.skeleton.names == ("head",) and body.shapes.names == ("smile",)
    pose = load_motion(body, Time(1003, 24.0), (), file=file)
    np.testing.assert_array_equal(pose.transforms, body.skeleton.rest)
    np.testing.assert_allclose(pose.weights, [0.5], atol=1e-6)
    moved = load_mesh_cache(Time(1003, 24.0), (), rest=body, file=file).points
    np.testing.assert_allclose(moved, skin(body, pose).points, atol=1e-6)
    assert np.abs(moved - body.mesh.points).max() > 0.3


def test_blend_shapes_without_a_skeleton_are_named(stage, saved) -> None:
    smile(stage)
    remove(stage, "primvars:skel:jointIndices", "primvars:skel:jointWeights", "skel:skeleton")
    stage.RemovePrim("/char/skeleton")
    with pytest.warns(UserWarning, match="/char/mesh has blend shapes without a Skeleton to animate them"):
        body = read_body(saved(stage), None)
    assert not body.skeleton.names and body.shapes is None
    still = [PLACE.Transform(Gf.Vec3d(p)) for p in prim_of(stage).GetAttribute("points").Get()]
    np.testing.assert_allclose(body.mesh.points, still, atol=1e-6)


def test_names_that_do_not_fit_blend_shapes_are_reported(stage, saved) -> None:
    smile(stage)
    binding_of(stage).GetBlendShapesAttr().Set(["smile", "frown"])
    with pytest.warns(UserWarning, match="/char/mesh: skel:blendShapes has 2 names for 1 blend shapes, which are ig"):
        body = read_body(saved(stage), None)
    assert body.shapes is None and len(body.mesh.points) == N


def test_a_blend_shape_may_move_nothing(stage, saved) -> None:
    shape = smile(stage)
    shape.CreatePointIndicesAttr([])
    shape.GetOffsetsAttr().Set([])
    body = read_body(saved(stage), None)
    assert body.shapes.names == ("smile",) and body.shapes.rows.tolist() == [0, 0]


def test_weights_are_not_a_map(stage, saved) -> None:
    binding_of(stage).CreateJointIndicesPrimvar(False, 1).Set([2] * N)
    binding_of(stage).CreateJointWeightsPrimvar(False, 1).Set([1.0] * N)
    body = read_body(saved(stage), None)
    assert not body.maps and (body.joints == 2).all()


def add_hat(stage: Usd.Stage, path: str) -> None:
    """A triangle that no joint moves."""
    hat = UsdGeom.Mesh.Define(stage, path)
    hat.CreatePointsAttr([Gf.Vec3f(n, 0, n * n) for n in range(3)])
    hat.CreateFaceVertexCountsAttr([3])
    hat.CreateFaceVertexIndicesAttr([0, 1, 2])


def test_a_mesh_without_joints_under_a_bound_root_follows_the_first(stage, saved) -> None:
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/char")).CreateSkeletonRel().SetTargets(["/char/skeleton"])
    add_hat(stage, "/char/hat")
    with pytest.warns(UserWarning, match="/char/hat is not bound to a skeleton"):
        body = read_body(saved(stage), None)
    np.testing.assert_allclose(body.mesh.points[N:], [PLACE.Transform(Gf.Vec3d(n, 0, n * n)) for n in range(3)])
    assert (body.joints[N:] == 0).all() and (body.weights[N:, 0] == 1).all() and len(body.skeleton.names) == 4


def test_a_rigid_mesh_follows_its_joints_by_the_meshs_own_order(stage, saved) -> None:
    binding = binding_of(stage)
    binding.CreateJointsAttr(["hips/spine/tail", "hips"])
    binding.CreateJointIndicesPrimvar(True, 1).Set([0])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    body = read_body(saved(stage), None)
    np.testing.assert_allclose(body.mesh.points, baked(stage, rest_of(stage)), atol=2e-6)
    assert body.joints.shape == (N, 1) and (body.joints == 3).all() and (body.weights == 1).all()


def test_several_skeletons_become_one(stage, saved) -> None:
    second = UsdGeom.Xform.Define(stage, "/second").GetPrim()
    second.GetReferences().AddInternalReference("/char")
    second.SetTypeName("SkelRoot")
    add_hat(stage, "/hat")
    with pytest.warns(UserWarning, match="/hat is not bound to a skeleton"):
        body = read_body(saved(stage), None)
    skeleton = body.skeleton
    assert skeleton.parents.tolist() == [-1, 0, 1, 1, -1, 4, 5, 5] and len(set(skeleton.names)) == 8
    assert body.joints[N : 2 * N].min() == 4 and (body.joints[2 * N :] == 0).all()
    np.testing.assert_allclose(body.weights.sum(axis=1), 1)


NAN = float("nan")
BROKEN = [
    ("mesh.primvars:skel:jointIndices", [4] * 2 * N, "jointIndices has an index without a joint"),
    ("mesh.primvars:skel:jointIndices", [-1] * 2 * N, "jointIndices has an index without a joint"),
    ("mesh.primvars:skel:jointWeights", [-1.0] * 2 * N, "negative or not finite"),
    ("mesh.primvars:skel:jointWeights", [NAN] * 2 * N, "negative or not finite"),
    ("mesh.primvars:skel:jointWeights", [1.0], "do not fit the points"),
    ("mesh.primvars:skel:jointWeights", None, "do not fit the points"),
    ("mesh.primvars:skel:skinningMethod", "bent", "cannot be skinned by the method bent"),
    ("mesh.skel:joints", ["nobody"], "skel:joints names nobody"),
    ("skeleton.bindTransforms", [Gf.Matrix4d(1)], "bindTransforms do not fit"),
    ("skeleton.bindTransforms", [Gf.Matrix4d(0)] * 4, "cannot be inverted"),
    ("skeleton.restTransforms", [Gf.Matrix4d(NAN)] * 4, "not finite"),
    ("skeleton.joints", ["a/b", "a", "c", "d"], "do not form a tree"),
    ("mesh/smile.offsets", [Gf.Vec3f(0, 1, 0)] * 3, "smile: 3 offsets (one for each of 12 pointIndices of 0 to 11"),
    ("mesh/smile.pointIndices", [12] * N, "smile: 12 offsets"),
]
"""An attribute, its value, and the message."""


@pytest.mark.parametrize(("attribute", "value", "message"), BROKEN)
def test_broken_skeletons_are_refused_with_the_prim(stage, saved, attribute, value, message) -> None:
    binding_of(stage).CreateJointsAttr(JOINTS)
    binding_of(stage).CreateSkinningMethodAttr()
    smile(stage).CreatePointIndicesAttr()
    path, _, name = attribute.partition(".")
    if value is None:
        remove(stage, name)
    else:
        prim_of(stage, path).GetAttribute(name).Set(value)
    with pytest.raises(BadInput) as caught:
        read_body(saved(stage), None)
    assert message in str(caught.value) and f"/char/{path}" in str(caught.value)


@pytest.mark.parametrize(("kind", "value"), [("SetElementSize", 1), ("SetInterpolation", "faceVarying")])
def test_joints_and_weights_that_do_not_go_together_are_refused(stage, saved, kind, value) -> None:
    getattr(binding_of(stage).GetJointWeightsPrimvar(), kind)(value)
    with pytest.raises(BadInput, match="do not fit the points"):
        read_body(saved(stage), None)


def test_two_keys_of_a_blend_shape_at_one_weight_are_refused(stage, saved) -> None:
    between = smile(stage).CreateInbetween("full")
    between.SetOffsets([Gf.Vec3f(0, 1, 0)] * N)
    for weight, message in ((1.0, "a second key at the weight 1"), (0.0, "a key at the weight 0")):
        between.SetWeight(weight)
        with pytest.raises(BadInput, match=f"blend shape smile of mesh 0: {message}"):
            read_body(saved(stage), None)


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
    local = locals_of([at(*origin, turn=10 * n) for n, origin in enumerate(ORIGINS)])
    animate(stage, JOINTS, local, {"hips": 5.0, "hips/spine": -20.0, "hips/spine/head": 35.0})
    return saved(stage)


def posed_by(rest: Body, file: Path) -> dict[int, Mesh]:
    return {frame: skin(rest, load_motion(rest, Time(frame, 24.0), (), file=file)) for frame in FRAMES}


def assert_baked(file: Path, found: list[dict[int, Mesh]], *names: str, atol: float = 1e-6) -> None:
    """Compare skin at all frames with the points of meshes as OpenUSD bakes them."""
    stage = Usd.Stage.Open(str(file))
    assert UsdSkel.BakeSkinning(UsdSkel.Root.Get(stage, "/char"), Gf.Interval(FRAMES[0], FRAMES[-1]))
    for frame in FRAMES:
        baked = []
        for mesh in (UsdGeom.Mesh.Get(stage, f"/char/{name}") for name in names):
            world = mesh.ComputeLocalToWorldTransform(frame)
            baked += [world.Transform(Gf.Vec3d(p)) for p in mesh.GetPointsAttr().Get(frame)]
        for skinned in found:
            shown = 0.05 * np.array(baked)[:, [0, 2, 1]] * (1, 1, -1)
            np.testing.assert_allclose(skinned[frame].points, shown, atol=atol)


def test_poses_move_the_skin_as_openusd_bakes_it(moving):
    rest = load_body(file=moving)
    posed = posed_by(rest, moving)
    meshes = {frame: load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=moving) for frame in FRAMES}
    for frame in FRAMES:
        np.testing.assert_allclose(posed[frame].points, meshes[frame].points, atol=1e-8)
        np.testing.assert_allclose(posed[frame].velocities, meshes[frame].velocities, atol=1e-6)
    assert_baked(moving, [posed, meshes], "mesh", atol=1e-7)
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
        skeleton.GetRestTransformsAttr().Set(locals_of([at(*o, turn=-20 * n) for n, o in enumerate(ORIGINS)]))
    stage.Save()
    rest = load_body(file=moving)
    assert (rest.bound is not None) == bent and (rest.dual is not None) == (method == "dualQuaternion")
    meshes = {frame: load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=moving) for frame in FRAMES}
    assert_baked(moving, [posed_by(rest, moving), meshes], "mesh")


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
    assert_baked(moving, [posed_by(rest, moving)], "mesh", "brows")


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
