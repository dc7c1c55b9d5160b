"""Program that imports a shot into Blender: hair with a material for hair, body, level sets, frame range.

Blender is under the GNU GPL: this file is run as a program, and nothing imports it. `hairpipe blender` prints it with
a job, for Blender's text editor, or runs it with a job on standard input:

    shot     path of the USD file
    prims    purpose and look of its curves and volumes, by the name of the prim
    frames   first and last frame, and frames per second; None for a shot without time
    blend    file that is saved, and picture: file that is rendered; None: none
"""

import json
import sys
from typing import Any

import bpy
from mathutils import Vector

JOB: dict[str, Any] = {}
SAMPLES, WIDTH, HEIGHT, QUALITY = 64, 640, 640, 80
SURROUNDINGS = (0.3, 0.32, 0.36)
"""Radiance around the scene, linear."""


def main() -> None:
    """Import the shot, in an empty scene where the job is on standard input."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    job = json.load(sys.stdin)
    scene = import_shot(job["shot"], job["prims"], job["frames"])
    if job["picture"]:
        render(scene, job["picture"])
    if job["blend"]:
        bpy.ops.wm.save_as_mainfile(filepath=job["blend"])


def import_shot(shot: str, prims: dict[str, Any], frames: list[float] | None) -> Any:
    """Import hair, body and level sets into the current scene; return the scene."""
    known = set(bpy.data.objects)
    bpy.ops.wm.usd_import(filepath=shot, import_guide=True, import_all_materials=True, set_frame_range=True)
    scene = bpy.context.scene
    if frames:
        first, last, fps = frames
        scene.frame_start, scene.frame_end = int(first), int(last)
        scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
        scene.frame_set(int(first))
    for item in set(bpy.data.objects) - known:
        prim = prims.get(item.name.split(".")[0], {})
        if prim.get("purpose") == "guide":  # level sets and guides
            item.hide_render = True
            item.hide_set(True)
        if item.type == "CURVES":
            item.data.materials.clear()
            item.data.materials.append(hair_material(prim.get("material", "hair"), prim.get("look", {})))
    return scene


def hair_material(name: str, look: dict[str, Any]) -> Any:
    """Return a material of Blender's hair shader with the colour, roughness and index of refraction of a look."""
    material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfHairPrincipled"), nodes.new("ShaderNodeOutputMaterial")
    shader.parametrization = "COLOR"
    shader.inputs["Color"].default_value = (*look.get("diffuseColor", (0.09, 0.045, 0.013)), 1.0)
    shader.inputs["Roughness"].default_value = look.get("roughness", 0.4)
    shader.inputs["IOR"].default_value = look.get("ior", 1.55)
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def render(scene: Any, picture: str) -> None:
    """Render what is drawn at the first frame by Cycles, from the front."""
    shown = [item for item in scene.objects if item.type in ("CURVES", "MESH") and not item.hide_render]
    corners = [item.matrix_world @ Vector(corner) for item in shown for corner in item.bound_box]
    low, high = (Vector([pick(corner[k] for corner in corners) for k in range(3)]) for pick in (min, max))
    middle = (low + high) / 2
    size = (high - low).length
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = middle + Vector((0.4, -1.1, 0.2)) * size
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.clip_start = 0.01 * size
    camera.data.clip_end = 100.0 * size
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 4.0
    sun.rotation_euler = (0.7, 0.2, 0.5)
    for item in (camera, sun):
        scene.collection.objects.link(item)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*SURROUNDINGS, 1.0)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "WEBP" if picture.lower().endswith(".webp") else "PNG"
    scene.render.image_settings.quality = QUALITY
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    import_shot(JOB["shot"], JOB["prims"], JOB["frames"])
