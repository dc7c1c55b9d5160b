"""The node hands over a file, and with clips what has to lie beside it; others open them where they are published."""

import json
import shutil
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdVol

import hairpipe
from hairpipe.engine import File, Frames, Origin, Time, Workspace
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.vdb import inspect
from hairpipe.nodes.export_usd import export_usd
from hairpipe.nodes.export_vdb import export_vdb
from hairpipe.values import Groom, LevelSet, Mesh, Strands

NUMBERS = (1001, 1002, 1004)


def hair(frame: int) -> Strands:
    points = np.linspace(0, 1, 24, dtype=np.float32).reshape(8, 3) + np.float32(frame - 1001)
    return Strands(points, np.full((8, 3), 30, np.float32), np.array([0, 4, 8], np.int32), 8e-5)


def body(frame: int) -> Mesh:
    return Mesh(np.eye(3) + (frame - 1001), np.array([[0, 1, 2]], np.int32), np.full((3, 3), 30.0))


def export(folder: Path, layout: Literal["single", "clips"], volume: Frames[File] | None = None) -> File:
    folder.mkdir()
    frames = Frames(NUMBERS, hair), Frames(NUMBERS, body)
    return export_usd(
        *frames, None, volume, None, None, None, Time(1001, 30.0), (), Workspace(folder), layout=layout, name="shake"
    )


def test_simulated_strands_are_marked(tmp_path):
    def groom(ids: list[int], points: np.ndarray) -> Groom:
        count = len(ids)
        sites = np.zeros(count, np.int32), np.tile((1.0, 0.0, 0.0), (count, 1)), np.tile(np.eye(3, 4), (count, 1, 1))
        uv, offsets = np.zeros((count, 2), np.float32), 4 * np.arange(count + 1, dtype=np.int32)
        return Groom(points.astype(float), offsets, np.array(ids, np.int32), *sites, uv)

    whole, keys = groom([3, 7], hair(1001).points), groom([7], hair(1001).points[4:])
    settings = Time(1001, 30.0), (), Workspace(tmp_path)
    file = export_usd(Frames(NUMBERS, hair), None, whole, None, keys, None, None, *settings)
    stage = Usd.Stage.Open(str(file.path))
    primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/shot/hair")).GetPrimvar("groom_guide")
    assert list(primvar.Get()) == [0, 1] and primvar.GetInterpolation() == UsdGeom.Tokens.uniform
    with pytest.raises(BadInput, match="keys without the groom"):
        export_usd(Frames(NUMBERS, hair), None, None, None, keys, None, None, *settings)


def publish(file: File, folder: Path) -> None:
    for name, path in {"final.usd": file.path, **file.companions}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / name)


def level_set(folder: Path, frame: int) -> File:
    """A slab that rises by a voxel a frame, as OpenVDB."""
    height = (np.arange(9, dtype=np.float32) - np.float32(frame - 1000)) * np.float32(0.1)
    distance = np.broadcast_to(height[:, None], (1, 9, 9, 9)).copy()
    velocity, inner = np.zeros((1, 9, 9, 9, 3), np.float32), np.zeros((2, 2, 2, 4), np.float32)
    surface = LevelSet(np.zeros((1, 1, 1), np.int32), distance, velocity, inner, np.zeros(3), 0.1, 3)
    folder.mkdir()
    return export_vdb(surface, None, Time(frame, 30.0), Workspace(folder))


@pytest.mark.parametrize("layout", ["single", "clips"])
def test_the_published_file_has_every_frame_of_hair_body_and_level_set(
    tmp_path: Path, layout: Literal["single", "clips"]
) -> None:
    volume = Frames(NUMBERS, lambda frame: level_set(tmp_path / str(frame), frame))
    file = export(tmp_path / "workspace", layout, volume)
    publish(file, tmp_path / "out")
    shutil.rmtree(tmp_path / "workspace")
    stage = Usd.Stage.Open(str(tmp_path / "out" / "final.usd"))
    assert stage.GetTimeCodesPerSecond() == 30 and (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1001, 1004)
    for frame in NUMBERS:
        for name, given in (("hair", hair(frame)), ("body", body(frame))):
            np.testing.assert_array_equal(stage.GetAttributeAtPath(f"/shake/{name}.points").Get(frame), given.points)
    prim = UsdVol.Volume(stage.GetPrimAtPath("/shake/levelset"))
    fields = {name: UsdVol.OpenVDBAsset(stage.GetPrimAtPath(path)) for name, path in prim.GetFieldPaths().items()}
    assert set(fields) == {"surface", "vel"}
    assert np.allclose(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0), np.eye(4))
    for frame in NUMBERS:
        for name, field in fields.items():
            asset = field.GetFilePathAttr().Get(frame)
            assert asset.path == f"./shake.volume/shake.{frame}.vdb"
            grids = {grid.name: grid.grid_class for grid in inspect(Path(asset.resolvedPath))}
            assert name == field.GetFieldNameAttr().Get() and grids["surface"] == "level set"
        lower, upper = np.array(prim.GetExtentAttr().Get(frame))
        assert lower[1] == pytest.approx(max(0, (frame - 1000 - 2) * 0.1), abs=0.11) and 0 < upper[1] - lower[1] < 0.71
    assert UsdGeom.Imageable(prim).ComputePurpose() == "guide"
    found = [f.rule for f in lint(tmp_path / "out" / "final.usd", inspect) if "levelset" in f.path]
    assert set(found) == {"sample-gaps"}, "frame 1003 was left out, and nothing else is wrong"


GRAPH = """
schema = 1
frames = [1, 2]
fps = 24
[head]
type = "make_bust"
[groom]
type = "grow_groom"
in.scalp = "head"
strands = 20
[motion]
type = "load_motion"
in.rest = "head"
file = "{clip}"
[body]
type = "pose_body"
in = {{ rest = "head", pose = "motion" }}
[{hair}]
type = "carry_groom"
in = {{ groom = "groom", body = "body" }}
[unused]
type = "grow_groom"
in.scalp = "head"
[usd]
type = "export_usd"
in = {{ hair = "{hair}", groom = "groom" }}
"""


def origin_in(folder: Path, hair: str = "hair", clip: str = "a.glb", **settings: object) -> Origin:
    """The origin of a graph in a folder of its own."""
    folder.mkdir()
    shutil.copy(Path(hairpipe.__file__).parent.parent / "graphs" / "assets" / "nod.glb", folder / clip)
    (folder / "shot.toml").write_text(GRAPH.format(hair=hair, clip=clip))
    changes = {name.replace("__", "."): value for name, value in settings.items()}
    shot = hairpipe.load(folder / "shot.toml", changes, cache=folder / "cache")
    return Origin(**Resolver(shot.graph, Store(folder / "cache"), (1, 2)).origins["usd"])


def test_the_origin_is_the_graph_behind_a_file_without_paths(tmp_path):
    here, there = (origin_in(tmp_path / name, clip=clip) for name, clip in (("a", "a.glb"), ("b", "nod.glb")))
    assert here == there and str(tmp_path) not in repr(here)
    assert list(here.nodes) == ["head", "groom", "motion", "body", "hair", "usd"]  # not the unused one
    assert here.nodes["usd"]["in"] == {"hair": "hair", "groom": "groom"} and here.node == "usd"
    assert here.nodes["motion"]["settings"]["file"]["suffix"] == ".glb"


def test_the_key_of_an_origin_is_of_settings_and_not_of_names(tmp_path):
    key = origin_in(tmp_path / "a").key
    assert origin_in(tmp_path / "b", hair="tresses").key == key
    assert origin_in(tmp_path / "c", unused__strands=7).key == key
    assert origin_in(tmp_path / "d", groom__strands=21).key != key


def test_metadata_state_the_graph_and_equal_graphs_give_equal_bytes(tmp_path):
    origin = origin_in(tmp_path / "graph")
    frames = Frames(NUMBERS, hair), None, None, None, None, None, None
    files = []
    for name in "ab":
        (tmp_path / name).mkdir()
        files.append(export_usd(*frames, Time(1001, 30.0), (), Workspace(tmp_path / name), origin).path)
    assert files[0].read_bytes() == files[1].read_bytes()
    stage = Usd.Stage.Open(str(files[0]))
    notes = stage.GetDefaultPrim().GetCustomDataByKey("hairpipe")
    assert (notes["version"], notes["node"], notes["key"]) == (hairpipe.__version__, "usd", origin.key)
    assert json.loads(notes["nodes"]["groom"]) == origin.nodes["groom"]
