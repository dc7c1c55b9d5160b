"""Program that writes what Blender reads of a file as USD.

Blender is under the GNU GPL: this file is run as a program, and nothing imports it. `hairpipe convert` runs it with a
job on standard input:

    file       path of the file
    importers  operators that read it; versions of Blender have some of them, and the first is used
    made       path of the USD file
"""

import json
import sys
from typing import Any

import bpy

OF_SCENE = ("wm.open_mainfile", "wm.alembic_import")
WRITTEN = {
    "export_armatures": True,
    "export_shapekeys": True,
    "export_materials": False,
    "export_lights": False,
    "convert_world_material": False,
}


def main() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    job = json.load(sys.stdin)
    importer = next((name for name in job["importers"] if exists(name)), None)
    if importer is None:
        sys.exit(f"Blender {bpy.app.version_string} does not read this format; other versions do")
    given = {"load_ui": False, "use_scripts": False} if importer == "wm.open_mainfile" else {}
    operator(importer)(filepath=job["file"], **given)
    scene = bpy.context.scene
    if not scene.objects:
        sys.exit("there is no object in the file")
    frames = (scene.frame_start, scene.frame_end) if importer in OF_SCENE else keyed_frames()
    if frames:
        scene.frame_start, scene.frame_end = frames
        scene.frame_set(scene.frame_start)
    bpy.ops.wm.usd_export(filepath=job["made"], export_animation=frames is not None, **WRITTEN)


def exists(name: str) -> bool:
    try:
        operator(name).get_rna_type()
    except (AttributeError, KeyError):
        return False
    return True


def operator(name: str) -> Any:
    group, _, verb = name.partition(".")
    return getattr(getattr(bpy.ops, group), verb)


def keyed_frames() -> tuple[int, int] | None:
    """Return the first and the last frame that has a key, or None where nothing moves."""
    ranges = [action.frame_range for action in bpy.data.actions]
    if not ranges:
        return None
    first = min(first for first, _ in ranges)
    last = max(last for _, last in ranges)
    return int(first), -int(-last // 1)
