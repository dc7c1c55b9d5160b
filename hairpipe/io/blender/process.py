"""Run a program of this folder in Blender, in a child process that ends with this one."""

import json
import os
import subprocess
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from signal import Signals
from typing import Any

from hairpipe.child import command, environment
from hairpipe.errors import BadInput

IN_MODULE = "from hairpipe.child import die_with_parent; die_with_parent(); from {module} import main; main()"
IN_BLENDER = "import sys; sys.path.insert(0, {folder!r}); import {program}; {program}.main()"


def run_program(module: str, job: dict[str, Any], made: Sequence[Path], where: Path) -> None:
    """Run the program of a module of this folder, with a job on its standard input.

    made   files that it has to write; earlier ones are removed first
    where  file that messages name

    Raises BadInput where Blender is not installed, fails, or has not written a file.
    """
    for path in made:
        path.unlink(missing_ok=True)
    given = json.dumps(job).encode()
    child = subprocess.run(
        blender(module), input=given, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment()
    )
    last = (child.stdout.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
    if child.returncode < 0:
        raise BadInput(f"Blender was ended by {Signals(-child.returncode).name}", where=where)
    if child.returncode or not all(path.is_file() for path in made):
        raise BadInput(f"Blender failed: {last}", where=where)


def blender(module: str) -> list[str]:
    """Return the command that runs such a module in Blender: the module bpy, or the program blender."""
    if find_spec("bpy") is not None:
        return command(IN_MODULE.format(module=module))
    if found := which("blender"):
        code = IN_BLENDER.format(folder=os.fspath(Path(__file__).parent), program=module.rpartition(".")[2])
        return [found, "--background", "--factory-startup", "--python-exit-code", "1", "--python-expr", code]
    right = "blender in the PATH, or pip install 'hairpipe[cycles]' with Python 3.11 or 3.13"
    raise BadInput("Blender is not installed", where="bpy", right=right)
