"""Animated meshes in graphs: re-runs down to the frame, bodies at rest, sequences of files."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, Vt

import hairpipe
from hairpipe.body.preparation import prepare
from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.formats.registry import read_body
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.values import Mesh

BOX = np.array([[x, y, z] for x in (0.0, 0.2) for y in (0.0, 0.3) for z in (0.0, 0.1)])
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FRAMES = range(1001, 1013)


def moved(frame: float) -> np.ndarray:
    """The box in accelerated motion."""
    return BOX + np.array([0.5, 0.0, -1.0]) * ((frame - 1001) / 24) ** 2


def write_obj(path: Path, points: np.ndarray, sides: list[tuple[int, ...]] = SIDES) -> None:
    lines = ["# a box", "v 9 9 9", *("v " + " ".join(map(repr, map(float, point))) for point in points)]
    path.write_text("\n".join([*lines, *("f " + " ".join(str(i + 2) for i in side) for side in sides), ""]))


def write_sequence(folder: Path) -> Path:
    for frame in FRAMES:
        write_obj(folder / f"box.{frame}.obj", moved(frame))
    return folder / "box.####.obj"


def write_stage(path: Path) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    mesh = UsdGeom.Mesh.Define(stage, "/box")
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr(np.ravel(SIDES).tolist())
    for frame in FRAMES:
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(moved(frame).astype(np.float32)), frame)
    stage.Save()
    return stage


def load(file: Path, frame: int = 1004, fps: float = 24.0, cuts=(), **settings) -> Mesh:
    return load_mesh_cache(Time(frame, fps), cuts, file=file, **settings)


def test_a_sequence_of_obj_files_gives_points_and_velocities(tmp_path):
    mesh = load(write_sequence(tmp_path))
    np.testing.assert_allclose(mesh.points, moved(1004), atol=1e-12)
    np.testing.assert_allclose(mesh.velocities, np.tile(np.array([1.0, 0, -2.0]) * 3 / 24, (8, 1)), atol=1e-9)
    assert mesh.triangles.shape == (12, 3) and mesh.triangles.max() == 7


@pytest.mark.parametrize(
    ("frame", "fps", "settings", "sample"),
    [
        (5, 24.0, {"at": 1, "start": 1002.0}, 1006.0),
        (1004, 24.0, {"speed": 0.5}, 1002.5),
        (1900, 24.0, {}, 1012.0),
        (900, 24.0, {}, 1001.0),
    ],
)
@pytest.mark.filterwarnings("ignore:.*holds still")
def test_start_and_speed_lead_to_an_instant(tmp_path, frame, fps, settings, sample):
    mesh = load(write_sequence(tmp_path), frame, fps, **settings)
    np.testing.assert_allclose(mesh.points, moved(sample), atol=1e-9)
    rate = settings.get("speed", 1.0) * (1001 < frame < 1900 or frame == 5)
    np.testing.assert_allclose(mesh.velocities[:, 2], -2.0 * (sample - 1001) / 24 * rate, atol=1e-9)


def test_a_stage_of_another_rate_plays_in_seconds(tmp_path):
    write_stage(tmp_path / "box.usda")
    mesh = load(tmp_path / "box.usda", 1006, 60.0)  # 5 / 60 s later: two samples at 24 per second
    np.testing.assert_allclose(mesh.points, moved(1003), atol=1e-6)
    assert mesh.velocities[0, 2] == pytest.approx(-2.0 * 2 / 24, abs=1e-4)


def test_units_and_axes_are_those_of_the_body(tmp_path):
    file = write_sequence(tmp_path)
    rest = prepare(read_body(tmp_path / "box.1001.obj"), unit=0.1, up="z", joint="box", scalp=None)
    mesh = load(file, 1001, rest=rest, unit=0.1, up="z")
    np.testing.assert_array_equal(mesh.points, rest.mesh.points)
    np.testing.assert_array_equal(mesh.triangles, rest.mesh.triangles)


def test_a_mesh_of_another_body_is_refused(tmp_path):
    write_obj(tmp_path / "open.obj", BOX, SIDES[1:])
    rest = prepare(read_body(tmp_path / "open.obj"), unit=1.0, up="y", joint="box", scalp=None)
    with pytest.raises(BadInput, match=r"8 vertices and 12 triangles .*8 and 10"):
        load(write_sequence(tmp_path), rest=rest)
    write_obj(tmp_path / "other.obj", BOX, [(*side[1:], side[0]) for side in SIDES])
    rest = prepare(read_body(tmp_path / "other.obj"), unit=1.0, up="y", joint="box", scalp=None)
    mesh = load(write_sequence(tmp_path), rest=rest)  # cut along the other diagonals, as the body is
    np.testing.assert_array_equal(mesh.triangles, rest.mesh.triangles)
    write_obj(tmp_path / "mixed.obj", BOX, SIDES[::-1])
    rest = prepare(read_body(tmp_path / "mixed.obj"), unit=1.0, up="y", joint="box", scalp=None)
    with pytest.raises(BadInput, match="polygons are not those of the body"):
        load(write_sequence(tmp_path), rest=rest)


@pytest.mark.parametrize("name", ["box.obj", "box.1001.obj"])
def test_one_obj_file_holds_still(tmp_path, name):
    write_obj(tmp_path / name, BOX)
    mesh = load(tmp_path / name, 1900)
    np.testing.assert_array_equal(mesh.points, BOX)
    assert not mesh.velocities.any()


def test_files_of_a_sequence_are_links_to_files_of_its_suffix_alone(tmp_path):
    (tmp_path / "published").mkdir()
    (tmp_path / "shot").mkdir()
    file = write_sequence(tmp_path / "published")
    for frame in FRAMES:
        (tmp_path / "shot" / f"box.{frame}.obj").symlink_to(tmp_path / "published" / f"box.{frame}.obj")
    np.testing.assert_array_equal(load(tmp_path / "shot" / file.name).points, load(file).points)
    (tmp_path / "secret").write_text("v 1 2 3\n")
    (tmp_path / "shot" / "box.1013.obj").symlink_to(tmp_path / "secret")
    with pytest.raises(BadInput, match=r"box.1013.obj: the file is a link to .*/secret \(a link to a .obj file"):
        load(tmp_path / "shot" / file.name)


def test_one_file_of_a_sequence_is_read_with_a_word(tmp_path):
    write_sequence(tmp_path)
    with pytest.warns(UserWarning, match=r"box.1004.obj is one of 12 numbered files, .*box.####.obj reads all"):
        mesh = load(tmp_path / "box.1004.obj")
    np.testing.assert_array_equal(mesh.points, moved(1004))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: write_obj(f / "box.1005.obj", BOX, SIDES[::-1]), r"box.1005.obj: the faces have changed"),
        (lambda f: write_obj(f / "box.1005.obj", BOX[:7]), r"box.1005.obj, line 11: index 9 does not exist"),
        (lambda f: (f / "box.1005.obj").write_text("v 1 2 x\n"), r"box.1005.obj, line 1: '1 2 x' are not 3"),
        (lambda f: write_obj(f / "box.01005.obj", BOX), r"box.1005.obj and box.01005.obj have the same number"),
        (lambda f: [f.joinpath(f"box.{n}.obj").unlink() for n in FRAMES], r"no files \(files such as box.1001.obj"),
    ],
)
def test_bad_sequences_are_refused(tmp_path, change, message):
    file = write_sequence(tmp_path)
    change(tmp_path)
    with pytest.raises(BadInput, match=message):
        load(file)


def test_missing_files_are_named(tmp_path):
    file = write_sequence(tmp_path)
    (tmp_path / "box.1006.obj").unlink()
    with pytest.warns(UserWarning, match="after number 1005 are missing"):
        mesh = load(file, 1006)
    np.testing.assert_allclose(mesh.points, moved(1006), atol=1e-9)


GRAPH = """
schema = 1
frames = [1005, 1009]
fps = 24
box = { type = "load_mesh_cache", file = "FILE" }
wall = { type = "move_mesh", in.mesh = "box" }
"""


def computed(graph: Path, node: str) -> list[int]:
    """The frames of a node that the next run computes."""
    shot = hairpipe.load(graph)
    return [entry.task.frame for entry in shot.plan() if entry.task.node == node and entry.status != "cached"]


@pytest.mark.slow
@pytest.mark.parametrize("file", ["box.####.obj", "box.usda", "root.usda"])
def test_an_edit_of_a_sample_changes_the_frames_around_it(tmp_path, monkeypatch, file):
    monkeypatch.setenv("HAIRPIPE_CACHE", str(tmp_path / "store"))
    write_sequence(tmp_path)
    write_stage(tmp_path / "box.usda")
    (tmp_path / "root.usda").write_text("#usda 1.0\n(\nsubLayers = [@box.usda@]\nmetersPerUnit = 1\n)\n")
    (tmp_path / "shot.toml").write_text(GRAPH.replace("FILE", file))
    hairpipe.load(tmp_path / "shot.toml").run()
    assert not computed(tmp_path / "shot.toml", "wall")
    write_obj(tmp_path / "box.1007.obj", moved(1007) + 0.01)
    stage = Usd.Stage.Open(str(tmp_path / "box.usda"))
    points = Vt.Vec3fArray.FromNumpy((moved(1007) + 0.01).astype(np.float32))
    UsdGeom.Mesh.Get(stage, "/box").GetPointsAttr().Set(points, 1007)
    stage.Save()
    run = hairpipe.load(tmp_path / "shot.toml").run()
    again = [task.frame for task, status in run.statuses.items() if task.node == "wall" and status == "computed"]
    assert sorted(again) == [1006, 1007, 1008]
