"""Program that builds a scene in Blender and renders it.

Blender is under the GNU GPL: this file is run as a program, and nothing imports it. Arrays and pixels are in files,
standard input is a JSON object:

    arrays, pixels            names of the files, see `add_hair` and `add_body` for the arrays
    fibre, skin               materials, see `make_material`
    lamps, surroundings       see `add_lamp`; radiance of the surroundings, linear
    camera                    see `add_camera`
    samples, denoise, blur    samples per pixel; whether OpenImageDenoise is used; whether motion is blurred
    threads, parent           number of threads; process that the program ends with

Positions are in the caller's coordinates [m]; axes are four rows: right, up and backwards of a frame, and its origin.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

SEED = 1
BOUNCES = 256  # maximum number of bounces of a path: light in pale hair scatters many times


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
    """Add strands as Catmull-Rom curves, with a move while exposed, and the absorption over the radius of the hair."""
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
    """Add a distant disc of light: colour, irradiance at normal incidence [W/m^2], angular diameter [rad], axes."""
    light = bpy.data.lights.new("lamp", "SUN")
    light.color, light.energy, light.angle = lamp["colour"], lamp["irradiance"], lamp["angle"]
    add_object(light).matrix_world = lamp["axes"]


def add_surroundings(arrays: Any, colour: list[float]) -> None:
    """Add uniform light of a colour, and a picture as background: wall, (height, width, 4), linear.

    The denoiser uses light, not coverage: a background added after denoising would fray outlines.
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
    """Add data to the scene, and return its object."""
    shown = bpy.data.objects.new(data.name, data)
    bpy.context.scene.collection.objects.link(shown)
    return shown


def make_material(shader: str, shading: dict[str, Any], attribute: str, varied: str) -> Any:
    """Make a material of one shader node by Blender's names; the input `varied` is an attribute of the points."""
    material = bpy.data.materials.new(shader)
    nodes = material.node_tree.nodes
    nodes.clear()
    node = nodes.new(shader)
    output = nodes.new("ShaderNodeOutputMaterial")
    for name, value in shading["properties"].items():
        setattr(node, name, value)
    for name, value in shading["inputs"].items():
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


def render(options: dict[str, Any], path: Path) -> np.ndarray:
    """Return linear light, the top row first, (height, width, 3) float32."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode = "FIXED"
    scene.render.threads = options["threads"]
    # The shutter is open for one frame of one second, so that velocities are displacements.
    scene.render.use_motion_blur = options["blur"]
    scene.render.motion_blur_shutter = 1.0
    scene.render.fps = 1
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.seed = SEED
    cycles.samples = options["samples"]
    cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    # Light is not clamped, and lobes are not widened after the first bounce, so that multiple scattering is right.
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.use_denoising = options["denoise"]
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
