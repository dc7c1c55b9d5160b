"""Scene of Blender from a shot: the program that imports it, printed, or run in a child process."""

import json
import os
import subprocess
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from signal import Signals
from typing import Any

from hairpipe.child import command, environment
from hairpipe.errors import BadInput
from hairpipe.io.usd.apart import work_apart
from hairpipe.io.usd.drawn_prims import Drawn, find_drawn

NO_JOB = "JOB: dict[str, Any] = {}"
PROGRAM = Path(__file__).with_name("import_shot.py")
BOOT = (
    "from hairpipe.child import die_with_parent; die_with_parent();"
    "from hairpipe.io.blender.import_shot import main; main()"
)
OF_BLENDER = "import sys; sys.path.insert(0, {folder!r}); import import_shot; import_shot.main()"


def job_of(shot: Path, blend: Path | None = None, picture: Path | None = None) -> dict[str, Any]:
    """Return what the program needs: paths, and purposes and looks of the prims of the shot.

    Raises BadInput where the shot cannot be read.
    """
    found: Drawn = work_apart(find_drawn, shot)
    absolute = (None if path is None else os.fspath(path.resolve()) for path in (blend, picture))
    saved, drawn = absolute
    frames = None if found.frames is None else list(found.frames)
    return {"shot": os.fspath(shot.resolve()), "prims": found.prims, "frames": frames, "blend": saved, "picture": drawn}


def script_of(shot: Path) -> str:
    """Return the program for Blender's text editor, or for `blender --python`, that imports the shot."""
    before, line, after = PROGRAM.read_text(encoding="utf-8").partition(NO_JOB)
    return f"{before}{line[: -len('{}')]}{job_of(shot)!r}{after}"


def make_scene(shot: Path, blend: Path | None, picture: Path | None) -> None:
    """Import a shot into Blender, in a child process; save the scene, and render its first frame.

    Raises BadInput where the shot cannot be read, or where Blender is not installed or fails.
    """
    job = json.dumps(job_of(shot, blend, picture)).encode()
    for path in (blend, picture):
        if path is not None:
            path.unlink(missing_ok=True)
    child = subprocess.run(blender(), input=job, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment())
    last = (child.stdout.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
    if child.returncode < 0:
        raise BadInput(f"Blender was ended by {Signals(-child.returncode).name}", where=shot)
    if child.returncode or any(path is not None and not path.is_file() for path in (blend, picture)):
        raise BadInput(f"Blender failed: {last}", where=shot)


def blender() -> list[str]:
    """Return the command that runs the program in Blender: the module bpy, or the program blender."""
    if find_spec("bpy") is not None:
        return command(BOOT)
    if found := which("blender"):
        code = OF_BLENDER.format(folder=os.fspath(PROGRAM.parent))
        return [found, "--background", "--factory-startup", "--python-exit-code", "1", "--python-expr", code]
    right = "blender in the PATH, or pip install 'hairpipe[cycles]'; without -o the script is printed"
    raise BadInput("Blender is not installed", where="bpy", right=right)
