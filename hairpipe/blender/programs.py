"""Programs of this folder run by Blender in a child process: import, conversion to USD, simulation of a scene."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from signal import Signals
from tempfile import TemporaryDirectory
from typing import Any

from hairpipe.apart import work_apart
from hairpipe.blender.extension_zip import contents
from hairpipe.child import command, environment
from hairpipe.errors import BadInput
from hairpipe.formats.usd.stage import find_drawn
from hairpipe.plain_file import checked_size

IN_MODULE = "from hairpipe.child import die_with_parent; die_with_parent(); from {module} import main; main()"
IN_BLENDER = "import sys; sys.path.insert(0, {folder!r}); import {program}; {program}.main()"


def run_program(
    module: str, job: dict[str, Any], made: Sequence[Path], where: Path, report: Callable[[str], object] = len
) -> None:
    """Run the program of a module of this folder with a job; BadInput where it fails, or has not `made` all files.

    report  is given each line that it prints
    """
    for path in made:
        path.unlink(missing_ok=True)
    with subprocess.Popen(
        blender(module), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment()
    ) as child:
        assert child.stdin is not None and child.stdout is not None
        with suppress(BrokenPipeError), child.stdin:
            child.stdin.write(json.dumps(job).encode())
        last = "no message"
        for line in child.stdout:
            last = line.decode(errors="replace").strip() or last
            report(last)
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


NO_JOB = "JOB: dict[str, Any] = {}"
PROGRAM = Path(__file__).with_name("import_shot.py")


def job_of(shot: Path, blend: Path | None = None, picture: Path | None = None) -> dict[str, Any]:
    """Return what the program needs: paths, and purposes and looks of the prims of the shot."""
    saved, drawn = (None if path is None else os.fspath(path.resolve()) for path in (blend, picture))
    return {"shot": os.fspath(shot.resolve()), **work_apart(find_drawn, shot), "blend": saved, "picture": drawn}


def script_of(shot: Path) -> str:
    """Return the program for Blender's text editor, or for `blender --python`, that imports the shot."""
    before, line, after = PROGRAM.read_text(encoding="utf-8").partition(NO_JOB)
    return f"{before}{line[: -len('{}')]}{job_of(shot)!r}{after}"


def make_scene(shot: Path, blend: Path | None, picture: Path | None) -> None:
    """Import a shot into Blender, in a child process; save it, and render its first frame; BadInput if that fails."""
    made = [path for path in (blend, picture) if path]
    run_program("hairpipe.blender.import_shot", job_of(shot, blend, picture), made, shot)


IMPORTERS = {
    ".abc": ("wm.alembic_import",),
    ".blend": ("wm.open_mainfile",),
    ".dae": ("wm.collada_import",),
    ".fbx": ("wm.fbx_import", "import_scene.fbx"),
    ".glb": ("import_scene.gltf",),
    ".gltf": ("import_scene.gltf",),
    ".obj": ("wm.obj_import",),
    ".ply": ("wm.ply_import",),
    ".stl": ("wm.stl_import",),
}
"""Operators of Blender by the end of a file's name; versions of Blender have some of them, and the first is used."""
USD = (".usd", ".usda", ".usdc")


def convert(file: Path, made: Path) -> None:
    """Write a USD file of meshes, skeletons, blend shapes, curves and cameras of a file, as they move.

    Materials and lights are left out. An earlier file is replaced by a complete one only.

    Raises BadInput where the file cannot be read, and where Blender is not installed or does not read it.
    """
    importers = IMPORTERS.get(file.suffix.lower())
    if importers is None:
        raise BadInput("Blender does not read this format", where=file, right=", ".join(IMPORTERS))
    if made.suffix.lower() not in USD:
        raise BadInput("it does not end like a USD file", where=made, right=", ".join(USD))
    checked_size(file, f"a {file.suffix} file")
    made.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=made.parent, prefix=".convert-") as folder:
        whole = Path(folder, made.name)
        job = {"file": os.fspath(file.resolve()), "importers": importers, "made": os.fspath(whole.resolve())}
        run_program("hairpipe.blender.convert_file", job, [whole], file)
        whole.replace(made)


def simulate(
    file: Path, hair: str, output: Path | None, describe: Callable[[str], Any], report: Callable[[str], object]
) -> None:
    """Simulate a hair object of a .blend file as the extension does; BadInput where that fails.

    output    .blend file to save with the result; None: results lie next to the file, which is not changed
    describe  gives the document of a node type
    report    is given each line of progress, and each warning
    """

    def filtered(line: str) -> None:
        if re.match(r"\d+ % |Warning: ", line):  # Blender prints more
            report(line)

    checked_size(file, "a .blend file")
    job = {"file": os.fspath(file.resolve()), "hair": hair, "program": os.fspath(Path(sys.argv[0]).resolve())}
    with TemporaryDirectory() as folder:
        package = Path(folder, "hairpipe_extension")
        package.mkdir()
        for name, data in contents(describe).items():
            (package / name).write_bytes(data)
        job["extension"] = folder
        if output is None:
            run_program("hairpipe.blender.simulate_scene", job, [], file, filtered)
            return
        whole = output.resolve().with_name(
            f".{output.stem}.{os.getpid()}.blend"
        )  # paths in it are relative to its folder
        job["output"] = os.fspath(whole)
        try:
            run_program("hairpipe.blender.simulate_scene", job, [whole], file, filtered)
            whole.replace(output)
        finally:
            whole.unlink(missing_ok=True)
