"""The program that runs Blender: it builds the given scene, and renders it.

Blender is under the GNU GPL. So this is run as a program, and nothing imports it; JSON comes on standard input, arrays
and pixels are in files. Standard input says

    arrays, pixels            names of the files, see `add_hair` and `add_body` for the arrays
    fibre, skin               materials, see `make_material`
    lamps, surroundings       see `add_lamp`; radiance that comes from everywhere, linear
    camera                    see `add_camera`
    samples, denoise, blur    samples a pixel; whether OpenImageDenoise smooths them; whether what moves is blurred
    threads, parent           how many it may use, and the process that it ends with

Places are those of the caller [m]; axes are four rows: of a frame to the right, up and backwards, and its origin.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

SEED = 1
BOUNCES = 256
"""After which a path ends: pale hair is bright by light that many hairs have passed on."""


def main() -> None:
    """Render the scene on standard input."""
    scene = json.load(sys.stdin)
    if os.getppid() != scene["parent"]:
        sys.exit("the parent process has ended")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with np.load(scene["arrays"]) as arrays:
        add_hair(arrays, scene["fibre"])
        add_body(arrays, scene["skin"])
        add_surroundings(arrays, scene["surroundings"])
    for lamp in scene["lamps"]:
        add_lamp(lamp)
    add_camera(scene["camera"])
    pixels = Path(scene["pixels"])
    np.save(pixels, render(scene, pixels.with_suffix(".exr")))


def add_hair(arrays: Any, fibre: dict[str, Any]) -> None:
    """Add strands as Catmull-Rom curves: hair_points, hair_radii, hair_moves while exposed, hair_offsets.

    What the hair absorbs over its radius is in hair_absorptions.
    """
    curves = bpy.data.hair_curves.new("hair")
    curves.add_curves(np.diff(arrays["hair_offsets"]).tolist())
    curves.set_types(type="CATMULL_ROM")
    put(curves, "position", arrays["hair_points"])
    put(curves, "velocity", arrays["hair_moves"])
    put(curves, "radius", arrays["hair_radii"])
    put(curves, "absorption", arrays["hair_absorptions"])
    curves.materials.append(
        make_material("ShaderNodeBsdfHairPrincipled", fibre, "absorption", "Absorption Coefficient")
    )
    add_object(curves)


def add_body(arrays: Any, skin: dict[str, Any]) -> None:
    """Add triangles, smoothly shaded: body_points, body_moves, body_triangles, body_colours of the vertices."""
    mesh = bpy.data.meshes.new("body")
    mesh.from_pydata(arrays["body_points"], [], arrays["body_triangles"])
    mesh.shade_smooth()
    put(mesh, "velocity", arrays["body_moves"])
    put(mesh, "colour", arrays["body_colours"])
    mesh.materials.append(make_material("ShaderNodeBsdfPrincipled", skin, "colour", "Base Color"))
    add_object(mesh)


def add_lamp(lamp: dict[str, Any]) -> None:
    """Add a disc of light far away: colour, irradiance of what faces it [W/m^2], angle that it fills [rad], axes."""
    light = bpy.data.lights.new("lamp", "SUN")
    light.color, light.energy, light.angle = lamp["colour"], lamp["irradiance"], lamp["angle"]
    add_object(light).matrix_world = lamp["axes"]


def add_surroundings(arrays: Any, colour: list[float]) -> None:
    """Shed light of a colour from everywhere, and show a picture behind everything: wall, (height, width, 4), linear.

    The denoiser knows light, not coverage: were the wall put behind afterwards, outlines would be frayed.
    """
    wall = arrays["wall"]
    image = bpy.data.images.new("wall", wall.shape[1], wall.shape[0], float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(wall[::-1].astype(np.float32).ravel())
    world = bpy.data.worlds.new("surroundings")
    world.cycles.sampling_method = "NONE"
    nodes = world.node_tree.nodes
    link = world.node_tree.links.new
    nodes.clear()
    output, mix, path, place, texture, shown, shed = (
        nodes.new(f"ShaderNode{kind}")
        for kind in ("OutputWorld", "MixShader", "LightPath", "TexCoord", "TexImage", "Background", "Background")
    )
    texture.image = image
    shed.inputs["Color"].default_value = [*colour, 1.0]
    link(place.outputs["Window"], texture.inputs["Vector"])
    link(texture.outputs["Color"], shown.inputs["Color"])
    link(path.outputs["Is Camera Ray"], mix.inputs[0])
    link(shed.outputs[0], mix.inputs[1])
    link(shown.outputs[0], mix.inputs[2])
    link(mix.outputs[0], output.inputs["Surface"])
    bpy.context.scene.world = world


def add_camera(camera: dict[str, Any]) -> None:
    """Add a pinhole camera: width and height [pixels], angle of the shorter side [rad], nearest and farthest, axes."""
    lens = bpy.data.cameras.new("camera")
    scene = bpy.context.scene
    lens.sensor_fit = "HORIZONTAL" if camera["width"] <= camera["height"] else "VERTICAL"
    lens.angle, lens.clip_start, lens.clip_end = camera["angle"], camera["nearest"], camera["farthest"]
    scene.render.resolution_x, scene.render.resolution_y = camera["width"], camera["height"]
    scene.camera = add_object(lens)
    scene.camera.matrix_world = camera["axes"]


def add_object(data: Any) -> Any:
    """Put data into the scene, and return the object that shows it."""
    shown = bpy.data.objects.new(data.name, data)
    bpy.context.scene.collection.objects.link(shown)
    return shown


def make_material(shader: str, told: dict[str, Any], attribute: str, varied: str) -> Any:
    """Make a material of one shader node with these properties and inputs, by the names that Blender gives them.

    One more input, `varied`, is an attribute of the points.
    """
    material = bpy.data.materials.new(shader)
    nodes = material.node_tree.nodes
    nodes.clear()
    node = nodes.new(shader)
    output = nodes.new("ShaderNodeOutputMaterial")
    for name, value in told["properties"].items():
        setattr(node, name, value)
    for name, value in told["inputs"].items():
        node.inputs[name].default_value = value
    given = nodes.new("ShaderNodeAttribute")
    given.attribute_name = attribute
    material.node_tree.links.new(given.outputs["Vector"], node.inputs[varied])
    material.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def put(geometry: Any, name: str, values: np.ndarray) -> None:
    """Set an attribute of all points: vectors (n, 3) or numbers (n,)."""
    kind, field = ("FLOAT_VECTOR", "vector") if values.ndim == 2 else ("FLOAT", "value")
    attribute = geometry.attributes.get(name) or geometry.attributes.new(name, kind, "POINT")
    attribute.data.foreach_set(field, values.astype(np.float32).ravel())


def render(told: dict[str, Any], path: Path) -> np.ndarray:
    """Return linear light, the top row first, (height, width, 3) float32."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode = "FIXED"
    scene.render.threads = told["threads"]
    # The shutter is open for one frame, of one second: velocities are motions meanwhile.
    scene.render.use_motion_blur = told["blur"]
    scene.render.motion_blur_shutter = 1.0
    scene.render.fps = 1
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.seed = SEED
    cycles.samples = told["samples"]
    cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    # No light is cut off, and lobes are not widened after the first bounce: what hair passes on would be wrong.
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.use_denoising = told["denoise"]
    cycles.denoiser = "OPENIMAGEDENOISE"
    cycles.denoising_use_gpu = False
    file = scene.render.image_settings
    file.file_format, file.color_mode, file.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)[::-1, :, :3]
