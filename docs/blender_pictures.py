"""Pictures of the how-to on Blender, made as an artist makes them: a scene, the button Simulate, Cycles.

`python docs/blender_pictures.py FOLDER [NAME ...]`, after a run of graphs/demo.toml: the body is that of its shot.
Blender is the module bpy, and the extension is as hairpipe writes it.
"""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from hairpipe.app.api.node_types import describe
from hairpipe.blender.extension_zip import contents

HOME = Path(__file__).resolve().parent.parent
SHOT, STYLES = HOME / "out/demo/shot.usd", HOME / "graphs/assets/styles.usda"
FIRST, LAST, DRAWN = 1001, 1024, 1016
SIZE, SAMPLES, QUALITY = 480, 64, 80
TIE = Vector((0.0, 0.118, 0.375))
"""Place of the hair tie of the ponytail [m]."""
HEAD = (0.0, 0.0, 0.32)
"""What the camera looks at [m]."""
NECK = 0.14
"""Where the shirt ends [m]."""
WIDTH = 5.0
"""Times a hair is drawn as wide as it is: the curves stand for more hairs."""


def make_scene(file: Path) -> Any:
    """A saved scene with the moving bust of the demo; return the bust."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.wm.usd_import(filepath=str(SHOT), import_curves=False, import_volumes=False, set_frame_range=False)
    scene.frame_start, scene.frame_end, scene.render.fps = FIRST, LAST, 24
    scene.frame_set(FIRST)
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return next(item for item in scene.objects if item.type == "MESH")


def take_hair(file: Path, name: str, body: Any, every: int, colour: tuple[float, float, float]) -> Any:
    """Return every n-th curve of a prim of a USD file, still, as a hair object on a body."""
    known = set(bpy.data.objects)
    bpy.ops.wm.usd_import(filepath=str(file), import_meshes=False, import_volumes=False, set_frame_range=False)
    made = [item for item in bpy.data.objects if item not in known]
    hair = next(item for item in made if item.type == "CURVES" and item.name.startswith(name))
    place = hair.matrix_world.copy()
    hair.parent = None
    hair.matrix_world = place
    hair.modifiers.clear()
    for item in made:
        if item != hair:
            bpy.data.objects.remove(item)
    left_out = [row for row in range(len(hair.data.curves)) if row % every]
    if left_out:
        hair.data.remove_curves(indices=left_out)
    widen(hair, WIDTH * np.sqrt(every))
    hair.data.surface = body
    hair.data.materials.clear()
    hair.data.materials.append(material_of(name, "ShaderNodeBsdfHairPrincipled", colour, 0.3))
    return hair


def widen(hair: Any, times: float) -> None:
    radii = hair.data.attributes["radius"].data
    found = np.empty(len(radii), np.float32)
    radii.foreach_get("value", found)
    radii.foreach_set("value", found * np.float32(times))


def tie(hair: Any) -> None:
    """Mark the point of each curve that is nearest to the tie in the attribute "tied"."""
    points = np.empty(3 * len(hair.data.points), np.float32)
    hair.data.position_data.foreach_get("vector", points)
    away = np.linalg.norm(points.reshape(-1, 3) - np.array(hair.matrix_world.inverted() @ TIE), axis=1)
    tied = np.zeros(len(away), bool)
    for curve in hair.data.curves:
        begin = curve.first_point_index
        tied[begin + np.argmin(away[begin : begin + curve.points_length])] = True
    hair.data.attributes.new("tied", "BOOLEAN", "POINT").data.foreach_set("value", tied)
    hair.hairpipe.pins = "tied"


def dress(body: Any) -> Any:
    """Return a shirt: a copy of the body below the neck, with its modifiers, a little larger."""
    shirt = body.copy()
    shirt.data = body.data.copy()
    shirt.name = "Shirt"
    for collection in body.users_collection:
        collection.objects.link(shirt)
    heights = [(body.matrix_world @ vertex.co).z for vertex in body.data.vertices]
    worn = shirt.vertex_groups.new(name="worn")
    worn.add([row for row, height in enumerate(heights) if height < NECK], 1.0, "REPLACE")
    shirt.modifiers.new("worn", "MASK").vertex_group = "worn"
    larger = shirt.modifiers.new("larger", "DISPLACE")
    larger.strength, larger.mid_level = 0.004, 0.0
    shirt.data.materials.clear()
    shirt.data.materials.append(material_of("cloth", "ShaderNodeBsdfDiffuse", (0.05, 0.12, 0.25), 0.8))
    return shirt


def material_of(name: str, shader: str, colour: tuple[float, float, float], roughness: float) -> Any:
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    surface = nodes.new(shader)
    surface.inputs["Color"].default_value = (*colour, 1.0)
    surface.inputs["Roughness"].default_value = roughness
    material.node_tree.links.new(surface.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def draw(picture: Path, eye: tuple[float, float, float]) -> None:
    """Render a frame by Cycles; eye: direction from the head to the camera."""
    scene = bpy.context.scene
    scene.frame_set(DRAWN)
    middle = Vector(HEAD)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.lens = 85.0
    camera.location = middle + 1.35 * Vector(eye).normalized()
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    for name, energy, size, place in (("key", 45.0, 0.5, (-1.1, -1.2, 1.3)), ("rim", 60.0, 0.4, (1.0, 1.2, 1.2))):
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "AREA"))
        lamp.data.energy, lamp.data.size = energy, size
        lamp.location = middle + Vector(place)
        lamp.rotation_euler = (middle - lamp.location).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.11, 0.13, 1.0)
    scene.camera, scene.render.engine, scene.cycles.samples = camera, "CYCLES", SAMPLES
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "WEBP", QUALITY
    scene.render.filepath = str(picture)
    bpy.ops.render.render(write_still=True)


def draw_fringe(folder: Path, picture: Path) -> None:
    body = make_scene(folder / "fringe.blend")
    fringe = take_hair(STYLES, "fringe", body, 1, (0.05, 0.024, 0.008))
    fringe.hairpipe.preset = "FINE"
    bpy.ops.hairpipe.simulate(name=fringe.name)
    draw(picture, (0.45, -1.0, 0.12))


def draw_ponytail(folder: Path, picture: Path) -> None:
    body = make_scene(folder / "ponytail.blend")
    tail = take_hair(STYLES, "ponytail", body, 1, (0.12, 0.05, 0.012))
    tie(tail)
    bpy.ops.hairpipe.simulate(name=tail.name)
    draw(picture, (1.0, -0.35, 0.12))


def draw_garment(folder: Path, picture: Path) -> None:
    body = make_scene(folder / "garment.blend")
    hair = take_hair(SHOT, "hair", body, 2, (0.06, 0.03, 0.012))
    entry = hair.hairpipe.colliders.add()
    entry.item = dress(body)
    entry.sheet = True
    hair.hairpipe.preset = "MEDIUM"
    hair.hairpipe.surface.voxel = 3.0  # mm
    bpy.ops.hairpipe.simulate(name=hair.name)
    draw(picture, (0.5, -1.0, 0.15))


PICTURES = {"fringe": draw_fringe, "ponytail": draw_ponytail, "garment": draw_garment}


def main(output: Path, names: list[str]) -> None:
    os.environ["HAIRPIPE"] = str(Path(sys.executable).with_name("hairpipe"))
    with TemporaryDirectory() as name:
        package = Path(name, "hairpipe_extension")
        package.mkdir()
        for file, data in contents(describe).items():
            (package / file).write_bytes(data)
        sys.path.insert(0, name)
        import hairpipe_extension  # pyright: ignore[reportMissingImports]

        hairpipe_extension.register()
        for picture in names or PICTURES:
            PICTURES[picture](Path(name), output / f"blender_{picture}.webp")
        hairpipe_extension.stop()


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
