"""Scene of Blender from a shot: the program that imports it, printed, or run in a child process."""

import os
from pathlib import Path
from typing import Any

from hairpipe.apart import work_apart
from hairpipe.io.blender.process import run_program
from hairpipe.io.usd.drawn_prims import Drawn, find_drawn

NO_JOB = "JOB: dict[str, Any] = {}"
PROGRAM = Path(__file__).with_name("import_shot.py")


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
    made = [path for path in (blend, picture) if path]
    run_program("hairpipe.io.blender.import_shot", job_of(shot, blend, picture), made, shot)
