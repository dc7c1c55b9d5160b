"""The node hands over a file, and with clips what has to lie beside it; others open them where they are published."""

import shutil
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hairpipe.nodes.export_usd import export_usd
from pxr import Usd

from hairpipe.data import Mesh, Strands
from hairpipe.errors import BadInput
from hairpipe.graph import File, Frames, Time, Workspace

NUMBERS = (1001, 1002, 1004)


def hair(frame: int) -> Strands:
    points = np.linspace(0, 1, 24, dtype=np.float32).reshape(8, 3) + np.float32(frame - 1001)
    return Strands(points, np.full((8, 3), 30, np.float32), np.array([0, 4, 8], np.int32), 8e-5)


def body(frame: int) -> Mesh:
    return Mesh(np.eye(3) + (frame - 1001), np.array([[0, 1, 2]], np.int32), np.full((3, 3), 30.0))


def export(folder: Path, layout: Literal["single", "clips"]) -> File:
    folder.mkdir()
    frames = Frames(NUMBERS, hair), Frames(NUMBERS, body)
    return export_usd(*frames, None, Time(1001, 30.0), Workspace(folder), layout=layout, name="shake")


@pytest.mark.parametrize("layout", ["single", "clips"])
def test_the_published_file_has_every_frame(tmp_path: Path, layout: Literal["single", "clips"]) -> None:
    file = export(tmp_path / "workspace", layout)
    assert bool(file.companions) == (layout == "clips")
    for name, path in {"final.usd": file.path, **file.companions}.items():
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, tmp_path / "out" / name)
    shutil.rmtree(tmp_path / "workspace")
    stage = Usd.Stage.Open(str(tmp_path / "out" / "final.usd"))
    assert stage.GetTimeCodesPerSecond() == 30 and (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1001, 1004)
    for frame in NUMBERS:
        points = [stage.GetAttributeAtPath(f"/shake/{name}.points").Get(frame) for name in ("hair", "body")]
        np.testing.assert_array_equal(points[0], hair(frame).points)
        np.testing.assert_array_equal(points[1], body(frame).points)


@pytest.mark.parametrize("layout", ["single", "clips"])
def test_the_same_input_gives_the_same_bytes(tmp_path: Path, layout: Literal["single", "clips"]) -> None:
    first, second = (export(tmp_path / name, layout) for name in ("a", "b"))
    assert first.path.read_bytes() == second.path.read_bytes()
    assert [p.read_bytes() for p in first.companions.values()] == [p.read_bytes() for p in second.companions.values()]


def test_refuses_a_name_that_usd_does_not_know(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="'a/b' cannot name a prim"):
        export_usd(Frames(NUMBERS, hair), None, None, Time(1001, 30.0), Workspace(tmp_path), name="a/b")
