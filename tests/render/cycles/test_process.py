"""Blender ends as its parent does, and its faults are one line; that it is installed is not needed to see it."""

import subprocess
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

from hairpipe.child import command
from hairpipe.engine.code import CodeReader
from hairpipe.errors import BadInput
from hairpipe.render import cycles as process
from hairpipe.render.cycles import run_blender

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
