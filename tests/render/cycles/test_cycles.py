"""Cycles sees what the preview sees, blurs what moves, and gives the same bytes again; it ends as its parent does."""

import subprocess
import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hairpipe.child import command
from hairpipe.engine.code import CodeReader
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import write_png
from hairpipe.render import cycles as process
from hairpipe.render import cycles as scene
from hairpipe.render.camera import Shot
from hairpipe.render.cycles import Exposure, Fibre, run_blender, trace_hair
from hairpipe.render.film import backdrop, develop
from hairpipe.values import Mesh, Strands

from ..conftest import draw_portrait, make_strands

needs_blender = pytest.mark.skipif(find_spec("bpy") is None, reason="Blender is not installed: no bpy for this Python")
RED = Fibre(1.0, np.array([0.6, 0.05, 0.02]))
SHOT = Shot(150, 100, eye=(0.5, 1.75, 0.9), target=(0.03, 1.55, 0.0))
STILL = Exposure(samples=2, denoise=True, shutter=0.0)


def render_hair(*given: Any) -> np.ndarray:
    return develop(trace_hair(*given), 1)


@pytest.fixture(scope="module")
def thick(hair: Strands) -> Strands:
    """Strands that are pixels wide."""
    return replace(hair, diameter=6e-3)


@pytest.fixture(scope="module")
def picture(thick: Strands, head: Mesh, tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    """Red hair on a head."""
    return render_hair(thick, head, SHOT, RED, STILL, tmp_path_factory.mktemp("cycles"))


def before_the_wall(picture: np.ndarray) -> np.ndarray:
    """Where hair or body is, (height, width) bool: the wall is blue."""
    return picture[..., 0] > picture[..., 2]


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    return np.sum(a & b) / np.sum(a | b)


@needs_blender
def test_camera_and_strands_are_those_of_the_preview(thick: Strands, head: Mesh, picture: np.ndarray) -> None:
    seen, drawn = map(before_the_wall, (picture, draw_portrait(thick, head, SHOT, RED.colour, 1.0)))
    assert 0.2 < drawn.mean() < 0.8
    assert overlap(seen, drawn) > 0.9
    assert max(overlap(np.roll(seen, shift, axis), drawn) for axis in (0, 1) for shift in (-2, 2)) < 0.9


@needs_blender
def test_the_same_bytes_again_on_one_thread(thick, head, picture, threads, tmp_path):
    threads(1)
    again = render_hair(thick, head, SHOT, RED, STILL, tmp_path)
    for name, pixels in (("first", picture), ("second", again)):
        write_png(tmp_path / name, pixels)
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()


@needs_blender
def test_motion_blur_is_along_the_path_with_and_without_a_body(tmp_path: Path) -> None:
    """A strand that stands upright moves to the right by a third of the picture while the shutter is open."""
    points = np.c_[np.zeros(9), np.linspace(1.7, 1.4, 9), np.zeros(9)].astype(np.float32)
    moves = np.tile(np.float32([1.0, 0.0, 0.0]), (9, 1))
    strand = Strands(points, moves, np.array([0, 9], np.int32), 0.03)
    shot = Shot(96, 64, eye=(0.0, 1.55, 1.5), target=(0.0, 1.55, 0.0))
    blurred = render_hair(strand, None, shot, RED, Exposure(16, False, 0.3), tmp_path)
    tint = (blurred - develop(backdrop(64, 96), 1).astype(float))[10:40].mean(axis=0) @ [1.0, 0.0, -1.0]
    columns = np.flatnonzero(tint > 0.5 * np.median(tint[40:56]))
    focal = 32 / np.tan(np.radians(12.0))
    assert columns.mean() == pytest.approx(47.5, abs=1.5)
    assert len(columns) == pytest.approx(focal * 0.3 / 1.5, rel=0.15)


def test_invalid_scenes_are_refused_before_blender_starts(
    hair: Strands, head: Mesh, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(scene, "run_blender", None)
    lost = replace(hair, velocities=np.full_like(hair.velocities, np.nan))
    with pytest.raises(BadInput, match="a velocity is not finite"):
        render_hair(lost, head, SHOT, RED, replace(STILL, shutter=0.01), tmp_path)
    with pytest.raises(BadInput, match="300 strands have points that are not finite"):
        render_hair(replace(hair, points=lost.velocities), head, SHOT, RED, STILL, tmp_path)


@needs_blender
def test_a_lock_that_absorbs_nothing_is_not_seen_in_a_furnace(monkeypatch, tmp_path):
    for name, stand_in in (("studio", lambda axes: []), ("EDGE", np.ones(3))):
        monkeypatch.setattr(scene, name, stand_in)
    # Strands of white hair vary, and absorb a little.
    monkeypatch.setattr(scene, "absorption_of", np.zeros_like)
    monkeypatch.setattr(scene, "backdrop", lambda height, width: np.ones((height, width, 3)))
    roots = np.random.default_rng(1).uniform(-0.02, 0.02, (2000, 1, 3))
    lock = make_strands(roots + np.linspace(0.0, 0.2, 9)[:, None] * [0.0, -1.0, 0.0])
    shot, white = Shot(40, 40, eye=(0.0, -0.1, 0.3), target=(0.0, -0.1, 0.0)), Fibre(1.0, np.ones(3))
    seen = trace_hair(lock, None, shot, white, replace(STILL, samples=8, denoise=False), tmp_path)
    assert seen[:, 15:25].mean() == pytest.approx(1.0, abs=0.01)


SLEEPS = "import os, time\nopen(os.environ['BORN'], 'w').write(str(os.getpid()))\ntime.sleep(60)\n"


@pytest.fixture
def blender(tmp_path, monkeypatch):
    """Install a module in place of Blender's."""

    def install(code: str) -> Path:
        (tmp_path / "bpy.py").write_text(code)
        monkeypatch.syspath_prepend(str(tmp_path))
        return tmp_path

    return install


@pytest.mark.parametrize(
    ("code", "reported"),
    [
        ("import sys\nsys.exit('first line\\nlast line')", "bpy: Blender failed: last line"),
        (
            "raise ImportError('libXrender.so.1: not found')",
            "bpy: Blender failed: ImportError: libXrender.so.1: not found",
        ),
        ("import sys\nsys.exit(3)", "bpy: Blender failed: no message"),
        ("import os\nos.abort()", "bpy: Blender was ended by SIGABRT"),
        (
            "import os\nos.kill(os.getpid(), 9)",
            "bpy: Blender was ended by SIGKILL (fewer strands, a smaller picture, or more memory)",
        ),
    ],
)
def test_a_fault_of_blender_is_one_line(blender, code, reported):
    with pytest.raises(BadInput) as fault:
        run_blender({}, {}, blender(code))
    assert str(fault.value) == reported


def test_blender_ends_with_the_process_that_waits_for_it(blender, monkeypatch):
    folder = blender(SLEEPS)
    born = folder / "born"
    monkeypatch.setenv("BORN", str(born))
    code = "from hairpipe.render.cycles import run_blender; from pathlib import Path; "
    parent = subprocess.Popen(command(code + f"run_blender({{}}, {{}}, Path({str(folder)!r}))"))
    wait_for(lambda: born.is_file() and born.read_text())
    parent.kill()
    parent.wait()
    wait_for(lambda: not is_running(int(born.read_text())))


def wait_for(holds) -> None:
    deadline = time.monotonic() + 30.0
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def is_running(pid: int) -> bool:
    """Whether a process is there, and not one that has ended and waits to be asked how."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_without_blender_one_line_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(process, "find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"^bpy: Blender is not installed \(pip install 'hairpipe\[cycles\]'"):
        run_blender({}, {}, tmp_path)


def test_the_program_and_the_version_of_blender_count_in_keys():
    parts = CodeReader(lambda name, make: make()).code_of("hairpipe.nodes.render_cycles").parts
    assert "hairpipe.render.cycles_program" in parts
    assert (parts["bpy (version)"] != "none") == (find_spec("bpy") is not None)
