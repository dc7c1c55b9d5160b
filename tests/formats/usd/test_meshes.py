"""Meshes of stages, at rest and in motion, against analytic motion."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils, Vt

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.usd.meshes import MovingMeshes, read_body, read_moving
from hairpipe.values import Mesh

CUBE = np.array([[x, y, z] for x in (0.0, 2) for y in (0.0, 2) for z in (0.0, 2)])
QUADS = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens


def cube(stage: Usd.Stage, path: str = "/body", corners: list[int] = QUADS) -> UsdGeom.Mesh:
    """A cube of 2 units, its faces counter-clockwise seen from outside."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(CUBE.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr(corners)
    return mesh


def volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize(("up", "scale"), [("Y", 1.0), ("Y", 0.01), ("Z", 1.0), ("Z", 0.01)])
def test_stands_in_metres_with_y_up(new_stage, saved, up: str, scale: float) -> None:
    stage = new_stage(up, scale)
    UsdGeom.Xform.Define(stage, "/scene").AddTranslateOp().Set(Gf.Vec3d(10, 20, 30))
    cube(stage, "/scene/body")
    body = read_body(saved(stage), None)
    x, y, z = ((CUBE + np.array([10, 20, 30])) * scale).T
    expected = np.stack([x, y, z] if up == "Y" else [x, z, -y], axis=1)
    np.testing.assert_allclose(body.mesh.points, expected, rtol=0, atol=1e-6)
    assert volume(body.mesh) == pytest.approx(8 * scale**3)
    assert body.skeleton.names == () and body.weights.shape == body.joints.shape == (8, 0)


def test_takes_the_transform_of_the_earliest_time(new_stage, saved) -> None:
    stage = new_stage()
    op = UsdGeom.Xform.Define(stage, "/scene").AddTranslateOp()
    for time in (1001, 1002):
        op.Set(Gf.Vec3d(time, 0, 0), time)
    cube(stage, "/scene/body")
    assert read_body(saved(stage), None).mesh.points[:, 0].min() == pytest.approx(1001)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("left", [False, True])
def test_triangles_face_out_for_any_handedness(new_stage, saved, mirrored: bool, left: bool) -> None:
    stage = new_stage()
    mesh = cube(stage, corners=QUADS[::-1] if left else QUADS)
    mesh.CreateOrientationAttr(TOKENS.leftHanded if left else TOKENS.rightHanded)
    if mirrored:
        mesh.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    assert volume(read_body(saved(stage), None).mesh) == pytest.approx(8)


def test_leaves_holes_out_with_their_texture_coordinates(new_stage, saved) -> None:
    stage = new_stage()
    mesh = cube(stage)
    mesh.CreateHoleIndicesAttr([1])
    values = Vt.Vec2fArray([Gf.Vec2f(n, 2 * n) for n in range(24)])
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", TYPES.TexCoord2fArray, TOKENS.faceVarying).Set(values)
    read_in = read_body(saved(stage), None).mesh
    assert len(read_in.triangles) == 10 and read_in.uv.shape == (10, 3, 2)
    corner = {(v, f) for f in range(6) for v in QUADS[4 * f : 4 * f + 4] if f != 1}
    for triangle, uv in zip(read_in.triangles, read_in.uv, strict=True):
        at = uv[:, 0].astype(int)
        assert [QUADS[n] for n in at] == list(triangle) and (uv[:, 1] == 2 * at).all()
        assert {(v, n // 4) for v, n in zip(triangle, at, strict=True)} <= corner


@pytest.mark.parametrize("interpolation", [TOKENS.vertex, TOKENS.varying, TOKENS.faceVarying])
def test_lays_texture_coordinates_on_the_corners(new_stage, saved, interpolation: str) -> None:
    stage = new_stage()
    primvar = UsdGeom.PrimvarsAPI(cube(stage)).CreatePrimvar("st", TYPES.TexCoord2fArray, interpolation)
    per_vertex = interpolation != TOKENS.faceVarying
    primvar.Set(Vt.Vec2fArray([Gf.Vec2f(n, -n) for n in range(8)]))
    if not per_vertex:
        primvar.SetIndices(Vt.IntArray(QUADS))
    mesh = read_body(saved(stage), None).mesh
    np.testing.assert_array_equal(mesh.uv[..., 0], mesh.triangles)
    np.testing.assert_array_equal(mesh.uv[..., 1], -mesh.triangles)


@pytest.mark.parametrize(("scheme", "named"), [("catmullClark", True), ("none", False), (None, False)])
def test_a_cage_is_named_where_its_scheme_is_authored(new_stage, saved, scheme: str | None, named: bool) -> None:
    stage = new_stage()
    mesh = cube(stage)
    if scheme:
        mesh.CreateSubdivisionSchemeAttr(scheme)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        read_body(saved(stage), None)
    assert ["/body is a subdivision surface" in str(w.message) for w in warned] == [True] * named


def test_texture_coordinates_of_another_number_are_named_and_left_out(new_stage, saved) -> None:
    stage = new_stage()
    primvar = UsdGeom.PrimvarsAPI(cube(stage)).CreatePrimvar("st", TYPES.TexCoord2fArray, TOKENS.faceVarying)
    primvar.Set(Vt.Vec2fArray(17))
    message = r"given\.usda /body\.primvars:st has 17 elements, not 24 for faceVarying.*without texture coordinates"
    with pytest.warns(UserWarning, match=message):
        mesh = read_body(saved(stage), None).mesh
    assert mesh.uv is None and volume(mesh) == pytest.approx(8)


def test_a_unit_that_is_a_single_float_is_read(new_stage, saved, tmp_path: Path) -> None:
    """Other writers of crate files store 0.5 as a float (type 8), OpenUSD as a double (type 9)."""
    stage = new_stage(scale=0.5, name="given.usdc")
    cube(stage)
    data = saved(stage).read_bytes()
    double, single = (np.float32(0.5).tobytes() + bytes([0, 0, kind, 0x40]) for kind in (9, 8))
    assert data.count(double) == 1
    (tmp_path / "single.usdc").write_bytes(data.replace(double, single))
    assert volume(read_body(tmp_path / "single.usdc", None).mesh) == pytest.approx(8 * 0.5**3)


def test_float_primvars_on_vertices_are_maps(new_stage, saved) -> None:
    stage = new_stage()
    primvars = UsdGeom.PrimvarsAPI(cube(stage))
    primvars.CreatePrimvar("scalp", TYPES.FloatArray, TOKENS.vertex).Set([0, 0.25, 0.5, 1, 0, 0, 0, 1])
    primvars.CreatePrimvar("density", TYPES.DoubleArray, TOKENS.varying).Set([0.5] * 7 + [1.5])
    primvars.CreatePrimvar("colour", TYPES.Color3fArray, TOKENS.vertex).Set([Gf.Vec3f(0)] * 8)
    with pytest.warns(UserWarning, match=r"map density spans 0.5 to 1.5"):
        maps = read_body(saved(stage)).maps
    assert sorted(maps) == ["density", "scalp"] and maps["density"][7] == 1
    np.testing.assert_allclose(maps["scalp"], [0, 0.25, 0.5, 1, 0, 0, 0, 1])


def test_merges_all_that_is_shown_and_takes_one_prim_on_request(new_stage, saved) -> None:
    stage = new_stage()
    second = cube(stage, "/char/second")
    second.AddTranslateOp().Set(Gf.Vec3d(5, 0, 0))
    UsdGeom.PrimvarsAPI(second).CreatePrimvar("scalp", TYPES.FloatArray, TOKENS.vertex).Set([1.0] * 8)
    cube(stage, "/char/first").CreatePurposeAttr(TOKENS.render)
    cube(stage, "/char/hidden").MakeInvisible()
    cube(stage, "/char/proxy").CreatePurposeAttr(TOKENS.proxy)
    cube(stage, "/char/guide").CreatePurposeAttr(TOKENS.guide)
    path = saved(stage)
    both, one = read_body(path, None), read_body(path, "/char/first")
    assert len(both.mesh.points) == 16 and volume(both.mesh) == pytest.approx(16)
    assert both.maps["scalp"].sum() == 8 and len(both.weights) == 16
    assert len(one.mesh.points) == 8 and one.mesh.points.max() == 2 and not one.maps


def test_reads_instances(new_stage, saved) -> None:
    stage = new_stage()
    cube(stage, "/asset/body")
    for n in range(2):
        instance = UsdGeom.Xform.Define(stage, f"/world/n{n}")
        instance.GetPrim().GetReferences().AddInternalReference("/asset")
        instance.GetPrim().SetInstanceable(True)
        instance.AddTranslateOp().Set(Gf.Vec3d(10 * n, 0, 0))
    assert read_body(saved(stage), "/world").mesh.points[:, 0].max() == 12


def changed(change: Callable[[UsdGeom.Mesh], object]) -> Callable[[Usd.Stage], object]:
    return lambda stage: change(cube(stage))


def wrong_type(mesh: UsdGeom.Mesh, name: str) -> None:
    spec = mesh.GetPrim().GetStage().GetRootLayer().GetPrimAtPath(mesh.GetPath())
    Sdf.AttributeSpec(spec, name, TYPES.StringArray).default = Vt.StringArray(["a"])


BROKEN = {
    "no mesh": (lambda stage: UsdGeom.Xform.Define(stage, "/body"), "no visible Mesh"),
    "guides": (changed(lambda m: m.CreatePurposeAttr(TOKENS.guide)), "no visible Mesh (a prim of the type Mesh and"),
    "no points": (changed(lambda m: m.CreatePointsAttr([])), "no points"),
    "NaN": (
        changed(lambda m: m.CreatePointsAttr([Gf.Vec3f(0)] * 7 + [Gf.Vec3f(0, np.nan, 0)])),
        "element 7 is not finite",
    ),
    "index": (changed(lambda m: m.CreateFaceVertexIndicesAttr([*QUADS[:-1], 8])), "names point 8"),
    "negative index": (changed(lambda m: m.CreateFaceVertexIndicesAttr([-1, *QUADS[1:]])), "names point -1"),
    "short indices": (changed(lambda m: m.CreateFaceVertexIndicesAttr(QUADS[:-1])), "has 23 elements"),
    "two corners": (changed(lambda m: m.CreateFaceVertexCountsAttr([2, 4, 4, 4, 5, 5])), "face 0 has 2 corners"),
    "negative count": (changed(lambda m: m.CreateFaceVertexCountsAttr([-4, 8, 4, 4, 8, 4])), "face 0 has -4 corners"),
    "hole": (changed(lambda m: m.CreateHoleIndicesAttr([6])), "holeIndices has an index without a face"),
    "all holes": (changed(lambda m: m.CreateHoleIndicesAttr(range(6))), "all faces are holes"),
    "scale": (changed(lambda m: UsdGeom.SetStageMetersPerUnit(m.GetPrim().GetStage(), 0)), "metersPerUnit is 0"),
    "transform": (changed(lambda m: m.AddTranslateOp().Set(Gf.Vec3d(np.inf))), "transform is not finite"),
    "map": (
        changed(lambda m: UsdGeom.PrimvarsAPI(m).CreatePrimvar("scalp", TYPES.FloatArray, TOKENS.vertex).Set([1.0])),
        "has 1 elements (8 for vertex interpolation)",
    ),
    "type": (changed(lambda m: wrong_type(m, "holeIndices")), "holds a StringArray (an array of numbers)"),
}


@pytest.mark.parametrize(("plant", "message"), BROKEN.values(), ids=BROKEN)
def test_invalid_prims_are_refused_with_their_path(new_stage, saved, plant: Callable, message: str) -> None:
    stage = new_stage()
    plant(stage)
    with pytest.raises(BadInput) as caught:
        read_body(saved(stage), None)
    assert message in str(caught.value) and "given.usda" in str(caught.value)


def test_names_what_there_is_when_a_prim_is_not_there(new_stage, saved) -> None:
    stage = new_stage()
    cube(stage)
    path = saved(stage)
    for wrong in ("/bodi", "body", "", "//", "/body.points"):
        with pytest.raises(BadInput, match=r"no prim .*\(a path under /body\)"):
            read_body(path, wrong)


def test_reads_every_kind_of_usd_file(new_stage, tmp_path: Path) -> None:
    from pxr import UsdUtils

    stage = new_stage()
    cube(stage)
    for name in ("a.usdc", "a.usd", "a.usda", "A.USDA"):
        stage.Export(str(tmp_path / name))
    text = (tmp_path / "a.usda").read_bytes()
    (tmp_path / "crlf.usda").write_bytes(text.replace(b"\n", b"\r\n"))
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "a.usdc"), str(tmp_path / "a.usdz"))
    for name in ("a.usdc", "a.usd", "a.usda", "A.USDA", "crlf.usda", "a.usdz"):
        assert volume(read_body(tmp_path / name, None).mesh) == pytest.approx(8), name


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
