"""When a file plays: one rule for all formats, and a warning where its times and those of the shot do not meet."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt

from hairpipe.engine import Time
from hairpipe.engine.node.declare import First
from hairpipe.formats.gltf import find_take
from hairpipe.nodes.load_mesh_cache import load_mesh_cache

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
COUNT = 5
STEP = np.array([0.1, 0.0, 0.0])
"""Displacement of the triangle from sample to sample, of which the first one is at rest."""


def write_obj(folder: Path, begin: int, rate: float) -> Path:
    for k in range(COUNT):
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in (TRIANGLE + k * STEP).tolist()]
        (folder / f"m.{begin + k:04d}.obj").write_text("\n".join([*lines, "f 1 2 3", ""]))
    return folder / "m.####.obj"


def write_usd(folder: Path, begin: int, rate: float) -> Path:
    stage = Usd.Stage.CreateNew(str(folder / "m.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(rate)
    UsdGeom.Xform.Define(stage, "/a").AddTranslateOp().Set(Gf.Vec3d(0, 0, 0), 0.0)  # a constant with a sample
    mesh = UsdGeom.Mesh.Define(stage, "/a/m")
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    for k in range(COUNT):
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.float32(TRIANGLE + k * STEP)), begin + k)
    stage.Save()
    return folder / "m.usda"


def write_gltf(folder: Path, begin: int, rate: float) -> Path:
    times = (begin + np.arange(COUNT)) / rate
    arrays = [TRIANGLE, times[:, None], np.arange(COUNT)[:, None] * STEP]
    data = [np.float32(array).tobytes() for array in arrays]
    (folder / "m.bin").write_bytes(b"".join(data))
    ends = np.cumsum([0, *map(len, data)]).tolist()
    views = [{"buffer": 0, "byteOffset": a, "byteLength": len(d)} for a, d in zip(ends, data, strict=False)]
    kinds = ["SCALAR" if array.shape[1] == 1 else "VEC3" for array in arrays]
    accessors = [
        {"bufferView": k, "componentType": 5126, "count": len(array), "type": kind}
        for k, (array, kind) in enumerate(zip(arrays, kinds, strict=True))
    ]
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    content = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": ends[-1], "uri": "m.bin"}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "animations": [{"samplers": [{"input": 1, "output": 2}], "channels": [channel]}],
    }
    (folder / "m.gltf").write_text(json.dumps(content))
    return folder / "m.gltf"


def write_alembic(folder: Path, begin: int, rate: float) -> Path:
    """A mesh under a constant transform, which has a sample at 0."""
    pytest.importorskip("alembic3d")
    abc, geometry, core, imath = map(
        pytest.importorskip, ("alembic3d.Abc", "alembic3d.AbcGeom", "alembic3d.AbcCoreAbstract", "imath")
    )

    def array(kind, values):
        made = kind(len(values))
        np.asarray(made)[:] = values
        return made

    archive = abc.OArchive(str(folder / "m.abc"))
    times = archive.addTimeSampling(core.TimeSampling(1.0 / rate, begin / rate))
    space = geometry.OXform(archive.getTop(), "a", 0)
    space.getSchema().set(geometry.XformSample())
    mesh = geometry.OPolyMesh(space, "m", times)
    for k in range(COUNT):
        given = array(imath.V3fArray, TRIANGLE + k * STEP), array(imath.IntArray, [0, 2, 1]), array(imath.IntArray, [3])
        mesh.getSchema().set(geometry.OPolyMeshSchemaSample(*given))
    return folder / "m.abc"


WRITERS = {"obj": write_obj, "usd": write_usd, "gltf": write_gltf, "alembic": write_alembic}
formats = pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)


def sample_at(file: Path, frame: int, first: int = 1001, **settings: float) -> tuple[float, str]:
    """Return the sample that a frame shows, and the warnings."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        mesh = load_mesh_cache(Time(frame, 24.0), (), None, First(first), file=file, **settings)
    return float((mesh.points - TRIANGLE)[0, 0] / STEP[0]), "\n".join(str(w.message) for w in warned)


@formats
def test_times_that_reach_the_shot_are_kept_and_held_outside(tmp_path, write: Callable):
    file = write(tmp_path, 1001, 24.0)
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
    file = write(tmp_path, begin, 24.0)
    for k in (0, 3):
        found, warned = sample_at(file, shown + k, first)
        assert found == pytest.approx(k, abs=1e-4)
        own = f"frames {begin} to {begin + COUNT - 1} of this shot: they begin at frame {shown} instead"
        assert own in warned and f"at = {shown} states this" in warned
        assert sample_at(file, shown + k, first, at=shown) == (pytest.approx(k, abs=1e-4), "")


@formats
def test_a_start_shows_that_time_at_the_frame(tmp_path, write: Callable):
    file = write(tmp_path, 3, 24.0)
    assert sample_at(file, 1012, at=1010, start=4.0) == (pytest.approx(3, abs=1e-4), "")
    found, warned = sample_at(file, 1001, at=1001, start=1001.0)  # as the warning has it
    assert found == pytest.approx(4, abs=1e-4) and "at the frames 3 to 7 of this shot" in warned


@pytest.mark.parametrize("write", [write_usd, write_alembic])
def test_samples_of_another_rate_are_named_with_the_remedy(tmp_path, write: Callable):
    """A glTF file is read at the frames of the shot, and the numbers of files are frames."""
    file = write(tmp_path, 1001, 25.0)
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
