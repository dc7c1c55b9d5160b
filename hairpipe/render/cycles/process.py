"""Run Blender in a child process, which ends with this one.

Blender is under the GNU GPL: only `program.py` imports it, and only the child process runs that file.
"""

import json
import os
import subprocess
from importlib.util import find_spec
from pathlib import Path
from signal import SIGKILL, Signals
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from hairpipe.child import command, environment
from hairpipe.errors import BadInput

if TYPE_CHECKING:  # Keys include all imports: they depend on that program, and on the version of bpy.
    from hairpipe.render.cycles import program  # noqa: F401

BOOT = (
    "from hairpipe.child import die_with_parent; die_with_parent();"  # importing Blender takes seconds
    "from hairpipe.render.cycles.program import main; main()"
)
SMALLER = "fewer strands, a smaller picture, or more memory"


def run_blender(scene: dict[str, Any], arrays: dict[str, np.ndarray], folder: Path) -> np.ndarray:
    """Return the image of a scene by Cycles: linear light, (height, width, 3) float32.

    It uses the number of threads of numba; the light does not depend on it.

    scene   plain values, see `program.py`
    arrays  hair and body, see there
    folder  folder of the exchanged files, which are kept

    Raises BadInput, in one line, where Blender is not installed or fails.
    """
    if find_spec("bpy") is None:
        mend = "pip install 'hairpipe[cycles]', with Python 3.11 or 3.13"
        raise BadInput("Blender is not installed", where="bpy", right=mend)
    inputs, pixels = folder / "arrays.npz", folder / "pixels.npy"
    np.savez(inputs, **arrays)
    files = {"arrays": str(inputs), "pixels": str(pixels)}
    job = {**scene, **files, "threads": numba.get_num_threads(), "parent": os.getpid()}
    child = subprocess.run(
        command(BOOT),
        input=json.dumps(job).encode(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=environment() | {"TMPDIR": str(folder), "BLENDER_USER_RESOURCES": str(folder)},
    )
    if child.returncode < 0:
        right = SMALLER if -child.returncode == SIGKILL else None
        raise BadInput(f"Blender was ended by {Signals(-child.returncode).name}", where="bpy", right=right)
    if child.returncode > 0:
        *_, last = ["no message", *child.stderr.decode(errors="replace").strip().splitlines()]
        raise BadInput(f"Blender failed: {last}", where="bpy")
    return np.load(pixels)
