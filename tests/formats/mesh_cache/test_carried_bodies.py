"""The table of formats of bodies in the pages, and when a file plays: a square with everything in each format."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from hairpipe.body.skinning import skin
from hairpipe.engine import Time
from hairpipe.engine.node.declare import First
from hairpipe.formats.gltf import find_take
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.nodes.load_motion import load_motion
from tests.formats.gltf.test_gltf import Writer, write

alembic3d = pytest.importorskip("alembic3d")
Abc = pytest.importorskip("alembic3d.Abc")
AbcGeom = pytest.importorskip("alembic3d.AbcGeom")
imath = pytest.importorskip("imath")
core = pytest.importorskip("alembic3d.AbcCoreAbstract")

PAGE = Path(__file__).parents[3] / "docs" / "howto" / "animated_characters.md"
SQUARE = np.array([[0.0, 0, 0], [0.2, 0, 0], [0.2, 0.2, 0], [0, 0.2, 0]])
SPEED = np.array([0.24, 0.0, 0.0])
SHARE = 0.25
"""Part of the motion that is a blend shape, where a format has these and joints."""
STEP = SPEED / 24.0
COUNT = 5
"""Number of samples, the first of which is at rest."""


def square(sample: int) -> np.ndarray:
    return SQUARE + STEP * sample


def obj(folder: Path, begin: int = 1001, rate: float = 24.0) -> tuple[Path, Path]:
    for k in range(COUNT):
        points = [f"v {x:.9g} {y:.9g} {z:.9g}\nvt {5 * x:g} {5 * y:g}" for x, y, z in square(k)]
        (folder / f"a.{begin + k:04d}.obj").write_text("\n".join([*points, "f 1/1 2/2 3/3 4/4\n"]))
    return folder / f"a.{begin:04d}.obj", folder / "a.####.obj"


def ply(folder: Path, begin: int = 1001, rate: float = 24.0) -> tuple[Path, Path]:
    names = ("x", "y", "z", "scalp")
    head = "ply\nformat ascii 1.0\nelement vertex 4\n" + "".join(f"property float {name}\n" for name in names)
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    for k in range(COUNT):
        rows = [f"{x:.9g} {y:.9g} {z:.9g} 1" for x, y, z in square(k)]
        (folder / f"a.{begin + k:04d}.ply").write_text(head + "\n".join([*rows, "4 0 1 2 3\n"]))
    return folder / f"a.{begin:04d}.ply", folder / "a.####.ply"


def array(kind: Any, values: Any) -> Any:
    made = kind(len(values))
    np.asarray(made)[:] = values
    return made


def alembic(folder: Path, begin: int = 1001, rate: float = 24.0) -> tuple[Path, Path]:
    """A mesh under a constant transform, which has a sample at 0."""
    archive = Abc.OArchive(str(folder / "a.abc"))
    times = archive.addTimeSampling(core.TimeSampling(1.0 / rate, begin / rate))
    space = AbcGeom.OXform(archive.getTop(), "a", 0)
    space.getSchema().set(AbcGeom.XformSample())
    mesh = AbcGeom.OPolyMesh(space, "square", times)
    faces = AbcGeom.GeometryScope.kFacevaryingScope
    corners, sizes = array(imath.IntArray, [0, 3, 2, 1]), array(imath.IntArray, [4])
    coordinates = array(imath.V2fArray, (5 * SQUARE[[0, 3, 2, 1], :2]).astype(np.float32))
    points = AbcGeom.GeometryScope.kVertexScope
    scalp = AbcGeom.OFloatGeomParam(mesh.getSchema().getArbGeomParams(), "scalp", False, points, 1)
    for k in range(COUNT):
        sample = AbcGeom.OPolyMeshSchemaSample(array(imath.V3fArray, square(k)), corners, sizes)
        sample.setVelocities(array(imath.V3fArray, np.tile(1.1 * SPEED, (4, 1))))
        sample.setUVs(AbcGeom.OV2fGeomParamSample(coordinates, faces))
        mesh.getSchema().set(sample)
        scalp.set(AbcGeom.OFloatGeomParamSample(array(imath.FloatArray, np.ones(4)), points))
    return folder / "a.abc", folder / "a.abc"


def stage_of(path: Path, rate: float) -> tuple[Usd.Stage, UsdGeom.Mesh]:
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(rate)
    root = UsdSkel.Root.Define(stage, "/a")
    root.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0), 0.0)  # a constant with a sample
    mesh = UsdGeom.Mesh.Define(stage, root.GetPath().AppendChild("mesh"))
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    given = UsdGeom.PrimvarsAPI(mesh)
    coordinates = Vt.Vec2fArray.FromNumpy((5 * SQUARE[:, :2]).astype(np.float32))
    given.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex").Set(coordinates)
    given.CreatePrimvar("scalp", Sdf.ValueTypeNames.FloatArray, "vertex").Set([1.0] * 4)
    return stage, mesh


def vectors(points: np.ndarray) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(points.astype(np.float32))


def usd(folder: Path, begin: int = 1001, rate: float = 24.0) -> tuple[Path, Path]:
    stage, mesh = stage_of(folder / "a.usda", rate)
    for k in range(COUNT):
        mesh.CreatePointsAttr().Set(vectors(square(k)), begin + k)
        mesh.CreateVelocitiesAttr().Set(vectors(np.tile(1.1 * SPEED, (4, 1))), begin + k)
    stage.Save()
    return folder / "a.usda", folder / "a.usda"


def usd_skel(folder: Path) -> tuple[Path, Path]:
    stage, mesh = stage_of(folder / "a.usda", 24.0)
    mesh.CreatePointsAttr(vectors(SQUARE))
    skeleton = UsdSkel.Skeleton.Define(stage, "/a/skeleton")
    skeleton.CreateJointsAttr(["bone", "bone/tip"])
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)] * 2)
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)] * 2)
    shape = UsdSkel.BlendShape.Define(stage, "/a/mesh/slide")
    shape.CreateOffsetsAttr(vectors(np.tile(SHARE * SPEED, (4, 1))))
    animation = UsdSkel.Animation.Define(stage, "/a/animation")
    animation.CreateJointsAttr(["bone", "bone/tip"])
    animation.CreateRotationsAttr([Gf.Quatf(1)] * 2)
    animation.CreateScalesAttr([Gf.Vec3h(1)] * 2)
    animation.CreateBlendShapesAttr(["slide"])
    for k in range(COUNT):
        moved = np.array([(1.0 - SHARE) * STEP * k, np.zeros(3)])
        animation.CreateTranslationsAttr().Set(vectors(moved), 1001 + k)
        animation.CreateBlendShapeWeightsAttr().Set([k / 24.0], 1001 + k)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * 4)
    binding.CreateJointWeightsPrimvar(False, 2).Set([0.5] * 8)
    binding.CreateSkinningMethodAttr("dualQuaternion")
    binding.CreateBlendShapesAttr(["slide"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    stage.Save()
    return folder / "a.usda", folder / "a.usda"


def gltf(folder: Path, begin: int = 1001, rate: float = 24.0) -> tuple[Path, Path]:
    writer = Writer()
    given = {
        "POSITION": writer.add(SQUARE.astype(np.float32), "VEC3"),
        "TEXCOORD_0": writer.add((5 * SQUARE[:, :2]).astype(np.float32), "VEC2"),
        "JOINTS_0": writer.add(np.zeros((4, 4), np.uint8), "VEC4"),
        "WEIGHTS_0": writer.add(np.tile(np.float32([1, 0, 0, 0]), (4, 1)), "VEC4"),
        "_FLOW": writer.add(SQUARE.astype(np.float32), "VEC3"),
        "_SCALP": writer.add(np.ones(4, np.float32), "SCALAR"),
    }
    corners = writer.add(np.array([0, 1, 2, 0, 2, 3], np.uint16), "SCALAR")
    samples = np.arange(COUNT, dtype=np.float32)
    times = writer.add((begin + samples) / np.float32(rate), "SCALAR")
    moved = ((1.0 - SHARE) * STEP * samples[:, None]).astype(np.float32)
    sampler = {"input": times, "output": writer.add(moved, "VEC3")}
    weights = {"input": times, "output": writer.add(samples / np.float32(24.0), "SCALAR")}
    target = {"POSITION": writer.add(np.tile(SHARE * SPEED, (4, 1)).astype(np.float32), "VEC3")}
    channels = [
        {"sampler": 0, "target": {"node": 1, "path": "translation"}},
        {"sampler": 1, "target": {"node": 0, "path": "weights"}},
    ]
    content = writer.json(
        meshes=[{"primitives": [{"attributes": given, "indices": corners, "targets": [target]}]}],
        nodes=[{"mesh": 0, "skin": 0}, {"name": "bone"}],
        skins=[{"joints": [1]}],
        animations=[{"samplers": [sampler, weights], "channels": channels}],
    )
    return (write(folder / "a.gltf", content),) * 2


WRITERS: dict[str, Callable[[Path], tuple[Path, Path]]] = {
    "OBJ, a sequence": obj,
    "PLY, a sequence": ply,
    "Alembic": alembic,
    "USD, points": usd,
    "UsdSkel": usd_skel,
    "glTF": gltf,
}
COLUMNS = (
    "texture coordinates",
    "maps",
    "mesh in motion",
    "velocities",
    "pose of joints",
    "with blend shapes",
    "with dual quaternions",
)


def row_of(name: str, still: Path, moving: Path) -> str:
    """Write the row of a format, with what is read of it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rest = load_body(file=still)
        mesh = load_mesh_cache(Time(1003, 24.0), (), rest=rest, file=moving)
        has_pose = still.suffix in (".usda", ".gltf") and name != "USD, points"
    named = any("attributes that are not used: scalp" in str(warning.message) for warning in caught)
    assert (name == "glTF") == any("not used: _FLOW" in str(warning.message) for warning in caught)
    assert bool(rest.maps) + named == (name != "OBJ, a sequence"), "a map is neither read nor named"
    np.testing.assert_allclose(mesh.points, square(2), atol=1e-6)
    pose = load_motion(rest, Time(1003, 24.0), (), file=moving) if has_pose else None
    if pose is not None:
        np.testing.assert_allclose(skin(rest, pose).points, square(2), atol=1e-6)
    found = (
        rest.mesh.uv is not None,
        bool(rest.maps),
        np.abs(mesh.points - rest.mesh.points).max() > 1e-3,
        np.allclose(mesh.velocities, 1.1 * SPEED, atol=1e-5),
        has_pose,
        pose is not None and pose.weights is not None and np.allclose(pose.weights, 1 / 12, atol=1e-6),
        rest.dual is not None,
    )
    return f"| {name} | " + " | ".join("yes" if value else "" for value in found) + " |"


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_table_of_bodies_is_what_is_read(tmp_path):
    rows = []
    for number, (name, author) in enumerate(WRITERS.items()):
        folder = tmp_path / str(number)
        folder.mkdir()
        rows.append(row_of(name, *author(folder)))
    head = f"| format | {' | '.join(COLUMNS)} |\n|{' --- |' * (1 + len(COLUMNS))}\n"
    table = head + "\n".join(rows)
    assert table in PAGE.read_text(encoding="utf-8"), f"the table of {PAGE.name} is to be\n\n{table}\n"


PLAYED = {"obj": obj, "usd": usd, "gltf": gltf, "alembic": alembic}
formats = pytest.mark.parametrize("write", PLAYED.values(), ids=PLAYED)


def sample_at(file: Path, frame: int, first: int = 1001, **settings: float) -> tuple[float, str]:
    """Return the sample that a frame shows, and the warnings."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        warnings.filterwarnings("ignore", ".*not used")
        mesh = load_mesh_cache(Time(frame, 24.0), (), None, First(first), file=file, **settings)
    return float((mesh.points - SQUARE)[0, 0] / STEP[0]), "\n".join(str(w.message) for w in warned)


@formats
def test_times_that_reach_the_shot_are_kept_and_held_outside(tmp_path, write: Callable):
    file = write(tmp_path, 1001, 24.0)[1]
    for frame, sample in ((1001, 0), (1003, 2), (1005, 4)):
        assert sample_at(file, frame) == (pytest.approx(sample, abs=1e-4), "")
    for frame, sample in ((995, 0), (1010, 4)):
        found, warned = sample_at(file, frame, first=995)
        assert found == pytest.approx(sample, abs=1e-4)
        assert "at the frames 1001 to 1005 of this shot: outside of them it holds still" in warned


@formats
@pytest.mark.parametrize(("begin", "first", "shown"), [(0, 1001, 1001), (1, 991, 1001), (10, 2001, 2001)])
def test_times_before_the_shot_begin_at_its_begin(tmp_path, write: Callable, begin: int, first: int, shown: int):
    """At 1001, also in a shot with handles, or at the first frame of a later shot."""
    file = write(tmp_path, begin, 24.0)[1]
    for k in (0, 3):
        found, warned = sample_at(file, shown + k, first)
        assert found == pytest.approx(k, abs=1e-4)
        own = f"frames {begin} to {begin + COUNT - 1} of this shot: they begin at frame {shown} instead"
        assert own in warned and f"at = {shown} states this" in warned
        assert sample_at(file, shown + k, first, at=shown) == (pytest.approx(k, abs=1e-4), "")


@formats
def test_a_start_shows_that_time_at_the_frame(tmp_path, write: Callable):
    file = write(tmp_path, 3, 24.0)[1]
    assert sample_at(file, 1012, at=1010, start=4.0) == (pytest.approx(3, abs=1e-4), "")
    found, warned = sample_at(file, 1001, at=1001, start=1001.0)  # as the warning has it
    assert found == pytest.approx(4, abs=1e-4) and "at the frames 3 to 7 of this shot" in warned


@pytest.mark.parametrize("write", [usd, alembic])
def test_samples_of_another_rate_are_named_with_the_remedy(tmp_path, write: Callable):
    """A glTF file is read at the frames of the shot, and the numbers of files are frames."""
    file = write(tmp_path, 1001, 25.0)[1]
    _, warned = sample_at(file, 1001, at=1001)
    assert "1/25 s apart" in warned and "1/24 s: frames lie between samples (speed = 0.96" in warned
    for k in range(COUNT):
        assert sample_at(file, 1001 + k, at=1001, speed=0.96) == (pytest.approx(k, abs=1e-4), "")


@pytest.mark.parametrize(
    ("targets", "take"),
    [
        ([[(0, "rotation")], [(1, "weights")]], [0, 1]),  # Blender's armature and shape keys
        ([[(0, "rotation"), (1, "rotation")], [(1, "rotation")]], [0]),  # two clips
        ([[(0, "rotation")], [(1, "weights")], [(0, "rotation")], [(1, "weights")]], [0, 1]),
    ],
)
def test_animations_that_move_other_nodes_are_one_take(targets: list, take: list[int]):
    channels = [[{"target": {"node": node, "path": path}} for node, path in clip] for clip in targets]
    assert find_take([{"channels": clip} for clip in channels]) == take
