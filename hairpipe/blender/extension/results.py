"""Simulated hair in a scene: curves that read a USD cache by Blender's own modifier, and a preview while a run goes on.

A .blend file with a result needs neither this extension nor hairpipe: it is a hair curves object with a modifier.
"""

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from .scene import NUMBERS, Axes

KINDS = {"FLOAT": ("value", 1), "INT": ("value", 1), "BOOLEAN": ("value", 1), "INT8": ("value", 1)}
KINDS |= {"FLOAT2": ("vector", 2), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4)}
KINDS |= {"BYTE_COLOR": ("color", 4), "QUATERNION": ("value", 4)}
"""Name and size of what an attribute has at each place, by its type."""
MODIFIER = "Simulated hair"
MARK = "hairpipe preview"
"""Property of the objects of previews."""


def attach(scene: Any, original: Any, usd: Path, axes: Axes, ids: np.ndarray) -> Any:
    """Make or renew the result of a hair object: curves that read a USD file; return it.

    It has the materials and the attributes of the original, which is hidden.

    ids  index in the original of each curve that was written, (S,)
    Raises RuntimeError where Blender does not read the file.
    """
    result = original.hairpipe.result
    if result is not None:
        release_cache(result)  # else Blender would show what it has read of an earlier file of this name
    curves, cache, prim = import_curves(usd)
    copy_attributes(original.data, curves, ids)
    if result is None or result.name not in scene.objects:
        result = bpy.data.objects.new(f"{original.name} simulated", curves)
        for collection in original.users_collection or (scene.collection,):
            collection.objects.link(result)
        original.hairpipe.result = result
    else:
        old, result.data = result.data, curves
        if not old.users:
            bpy.data.hair_curves.remove(old)
    curves.name = result.name
    for slot in original.data.materials:
        curves.materials.append(slot)
    modifier = result.modifiers.new(MODIFIER, "MESH_SEQUENCE_CACHE")
    modifier.cache_file = cache
    modifier.object_path = prim
    result.modifiers.move(len(result.modifiers) - 1, 0)
    result.matrix_world = axes.matrix()
    hide(original)
    return result


def release_cache(result: Any) -> None:
    """Remove the modifier of a result, and its cache file if nothing else reads it."""
    for modifier in [m for m in result.modifiers if m.type == "MESH_SEQUENCE_CACHE"]:
        cache = modifier.cache_file
        result.modifiers.remove(modifier)
        if cache is not None and not cache.users:
            bpy.data.batch_remove([cache])


def import_curves(usd: Path) -> tuple[Any, Any, str]:
    """Return the curves of a USD file, its cache file, and the path of the prim; nothing else of it stays."""
    known = {kind: set(getattr(bpy.data, kind)) for kind in ("objects", "collections", "hair_curves", "materials")}
    scene = bpy.context.scene
    frames = scene.frame_start, scene.frame_end, scene.frame_current, scene.frame_subframe
    active = bpy.context.view_layer.objects.active
    selected = [*bpy.context.selected_objects]
    bpy.ops.wm.usd_import(filepath=str(usd), set_frame_range=False, import_guide=False, import_materials=False)
    scene.frame_start, scene.frame_end = frames[:2]
    scene.frame_set(frames[2], subframe=frames[3])
    new = [item for item in bpy.data.objects if item not in known["objects"]]
    found = next((item for item in new if item.type == "CURVES"), None)
    modifiers = [] if found is None else [m for m in found.modifiers if m.type == "MESH_SEQUENCE_CACHE"]
    if found is None or not modifiers:
        raise RuntimeError(f"{usd}: Blender finds no moving curves in it")
    curves = found.data
    cache = modifiers[0].cache_file
    prim = modifiers[0].object_path
    curves.use_fake_user = True
    for item in new:
        bpy.data.objects.remove(item)
    for kind in ("collections", "materials"):
        for block in [block for block in getattr(bpy.data, kind) if block not in known[kind]]:
            getattr(bpy.data, kind).remove(block)
    curves.use_fake_user = False
    for item in selected:
        item.select_set(True)
    bpy.context.view_layer.objects.active = active
    cache.filepath = relative(usd)
    return curves, cache, prim


def relative(path: Path) -> str:
    """Return a path from the .blend file, as Blender writes it, where there is one."""
    try:
        return bpy.path.relpath(str(path)) if bpy.data.filepath else str(path)
    except ValueError:  # on another drive
        return str(path)


def copy_attributes(original: Any, curves: Any, written: np.ndarray) -> None:
    """Copy surface and attributes of the original curves, by their ids; what the file has, as positions, stays.

    Attributes of points are copied where both have the same number of points. Blender 4.2 does not read ids: the curves
    are then those that were written, if they are as many.
    """
    curves.surface, curves.surface_uv_map = original.surface, original.surface_uv_map
    rows = written
    if (ids := curves.attributes.get("id")) is not None:
        rows = np.empty(len(ids.data), np.int32)
        ids.data.foreach_get("value", rows)
    if len(rows) != len(curves.curves) or not len(rows) or rows.max() >= len(original.curves):
        return
    counts = np.empty(len(original.curve_offset_data), np.int32)
    original.curve_offset_data.foreach_get("value", counts)
    sizes = np.diff(counts)
    firsts = counts[rows]
    along = np.repeat(firsts, sizes[rows]) + ramp(sizes[rows])
    for attribute in original.attributes:
        if attribute.name in curves.attributes or attribute.data_type not in KINDS or attribute.name.startswith("."):
            continue
        chosen = rows if attribute.domain == "CURVE" else along
        name, columns = KINDS[attribute.data_type]
        kind = NUMBERS.get(attribute.data_type, np.float32)
        values = np.empty(len(attribute.data) * columns, kind)
        attribute.data.foreach_get(name, values)
        copied = curves.attributes.new(attribute.name, attribute.data_type, attribute.domain)
        taken = np.ascontiguousarray(values.reshape(-1, columns)[chosen]).ravel()
        if len(copied.data) * columns == len(taken):
            copied.data.foreach_set(name, taken)
        else:
            curves.attributes.remove(copied)


def ramp(sizes: np.ndarray) -> np.ndarray:
    """Return 0, 1, ... for each of several sizes, one after the other."""
    return np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)


def hide(original: Any) -> None:
    """Hide the original in the viewport and in renders, and remember how it was."""
    kept = original.hairpipe
    if not kept.is_hidden:
        kept.is_hidden, kept.was_hidden, kept.was_unrendered = True, original.hide_viewport, original.hide_render
    original.hide_viewport = original.hide_render = True


def remove(original: Any) -> None:
    """Remove the result of a hair object, and show the original as it was."""
    kept = original.hairpipe
    if kept.result is not None:
        release_cache(kept.result)
        curves = kept.result.data
        bpy.data.objects.remove(kept.result)
        if not curves.users:
            bpy.data.hair_curves.remove(curves)
        kept.result = None
    if kept.is_hidden:
        original.hide_viewport, original.hide_render = kept.was_hidden, kept.was_unrendered
        kept.is_hidden = False


class Preview:
    """Curves that show the frames of a run as they arrive; they are removed when it ends."""

    def __init__(self, scene: Any, original: Any, count: int, sizes: list[int], axes: Axes) -> None:
        self.name = f"{original.name} (running)"
        self.files: dict[int, Path] = {}
        self.count = count
        curves = bpy.data.hair_curves.new(self.name)
        curves.add_curves(sizes)
        for slot in original.data.materials:
            curves.materials.append(slot)
        item = bpy.data.objects.new(self.name, curves)
        self.name = item.name
        item.matrix_world = axes.matrix()
        item.hide_render = item[MARK] = True
        scene.collection.objects.link(item)

    def arrive(self, frame: int, file: Path, points: int) -> None:
        if points == self.count:
            self.files[frame] = file

    def show(self, frame: int) -> None:
        """Show a frame, or the last one before it that has arrived."""
        item = bpy.data.objects.get(self.name)
        known = [number for number in self.files if number <= frame]
        if item is None or not known:
            return
        try:
            points = np.fromfile(self.files[max(known)], "<f4")
        except OSError:
            return
        if len(points) == 3 * self.count:
            item.data.position_data.foreach_set("vector", points)
            item.data.update_tag()


def discard_previews() -> None:
    """Remove all previews, also those that were saved in the file while a run went on."""
    for item in [item for item in bpy.data.objects if item.get(MARK)]:
        curves = item.data
        bpy.data.objects.remove(item)
        bpy.data.hair_curves.remove(curves)
