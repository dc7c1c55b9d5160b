"""Files that Blender reads, written as USD by Blender."""

import os
from pathlib import Path
from tempfile import TemporaryDirectory

from hairpipe.errors import BadInput
from hairpipe.io.blender.process import run_program
from hairpipe.plain_file import checked_size

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
        run_program("hairpipe.io.blender.convert_file", job, [whole], file)
        whole.replace(made)
