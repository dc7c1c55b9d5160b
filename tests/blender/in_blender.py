"""Cases that Blender runs in a process of its own: `python -m tests.blender.in_blender CASE FOLDER EXTENSION`.

Each is a function that works in a folder and returns what it found, which is printed as JSON in the last line.
"""

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np

CURVES, POINTS, RADIUS = 12, 6, 0.1
FIRST, STILL, LAST = 1001, 1016, 1024
"""The head turns in three frames and is still until the second; then it moves if a keyframe is set at the last."""


def make_head(name: str = "Head", scale: float = 1.0) -> Any:
    """A sphere that turns and becomes wider, with a vertex group."""
    import bmesh  # which is there once bpy is

    mesh = bpy.data.meshes.new(name)
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=24, v_segments=12, radius=RADIUS / scale)
    shape.to_mesh(mesh)
    mesh.uv_layers.new(name="UVMap")
    head = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(head)
    head.shape_key_add(name="Basis")
    wide = head.shape_key_add(name="wide")
    for point in wide.data:
        point.co.x *= 1.05
    for frame, value in ((FIRST, 0.0), (FIRST + 3, 1.0), (STILL, 1.0)):
        wide.value = value
        wide.keyframe_insert("value", frame=frame)
        head.rotation_euler = (0.0, 0.0, 0.5 * value)
        head.keyframe_insert("rotation_euler", frame=frame)
    group = head.vertex_groups.new(name="right")
    group.add([vertex.index for vertex in mesh.vertices if vertex.co.x > 0.0], 1.0, "REPLACE")
    return head


def make_hair(head: Any, name: str = "Hair", scale: float = 1.0, seed: int = 1, count: int = CURVES) -> Any:
    """Curves that stand on the upper half of a sphere and bend down, a child of it."""
    rng = np.random.default_rng(seed)
    out = rng.normal(size=(count, 3))
    out[:, 2] = np.abs(out[:, 2])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    along = np.linspace(0.0, 1.0, POINTS)[None, :, None]
    points = (RADIUS * out[:, None] * (1.0 + along) - 0.04 * along**2 * np.array([0.0, 0.0, 1.0])) / scale
    curves = bpy.data.hair_curves.new(name)
    curves.add_curves([POINTS] * count)
    curves.position_data.foreach_set("vector", points.astype(np.float32).ravel())
    curves.surface, curves.surface_uv_map = head, "UVMap"
    radii = curves.attributes.new("radius", "FLOAT", "POINT")
    radii.data.foreach_set("value", np.full(POINTS * count, 5e-5 / scale, np.float32))
    clump = curves.attributes.new("clump", "FLOAT", "CURVE")
    clump.data.foreach_set("value", np.linspace(0.1, 1.0, count, dtype=np.float32))
    curves.materials.append(bpy.data.materials.new("Brown"))
    hair = bpy.data.objects.new(name, curves)
    bpy.context.scene.collection.objects.link(hair)
    hair.parent = head
    return hair


def make_scene(file: Path | None, scale: float = 1.0) -> Any:
    """A saved scene of a head with hair; return the hair."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FIRST, LAST
    scene.render.fps, scene.render.fps_base = 25, 1.001
    scene.unit_settings.scale_length = scale
    hair = make_hair(make_head(scale=scale), scale=scale)
    bpy.context.view_layer.objects.active = hair
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return bpy.data.objects["Hair"]


def places(item: Any, frame: float) -> np.ndarray:
    """Where the points of curves are at a time, in the world, (p, 3)."""
    bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
    found = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    local = np.empty(3 * len(found.data.points), np.float32)
    found.data.position_data.foreach_get("vector", local)
    matrix = np.array(found.matrix_world)
    return local.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


@contextmanager
def refused() -> Iterator[list[str]]:
    """Take the message with which an operator ends."""
    said: list[str] = []
    try:
        yield said
    except RuntimeError as fault:
        said.append(str(fault).removeprefix("Error: ").strip())


def simulate(folder: Path) -> dict[str, Any]:
    """Simulate, change a keyframe, look at the plan, simulate again, remove; and once more from the saved file."""
    from hairpipe_extension.simulation import known

    hair = make_scene(folder / "mit ä blank" / "shot.blend")
    hair.name = "Hair"
    hair.hairpipe.simulation.material.young.map = "right"
    hair.hairpipe.simulation.material.young.low = 2.0
    bpy.context.scene.frame_set(FIRST + 2)
    bpy.ops.hairpipe.check()
    found: dict[str, Any] = {"first": known["Hair"].lines, "frame": bpy.context.scene.frame_current}
    bpy.ops.hairpipe.simulate()
    result = hair.hairpipe.result
    times = [FIRST, FIRST + 1, FIRST + 1.5, LAST]
    found["places"] = {moment: places(result, moment).tolist() for moment in times}
    found["attributes"] = sorted(attribute.name for attribute in result.data.attributes)
    clump = np.empty(CURVES, np.float32)
    result.data.attributes["clump"].data.foreach_get("value", clump)
    found["clump"] = clump.tolist()
    found["radius"] = result.data.attributes["radius"].data[0].value
    found["material"] = [material.name for material in result.data.materials]
    found["surface"] = result.data.surface.name
    found["hidden"] = hair.hide_viewport and hair.hide_render
    found["modifier"] = result.modifiers[0].cache_file.filepath
    bpy.ops.hairpipe.check()
    found["second"] = known["Hair"].lines
    head = bpy.data.objects["Head"]
    head.rotation_euler = (0.0, 0.4, 0.5)
    head.keyframe_insert("rotation_euler", frame=LAST)
    bpy.ops.hairpipe.check()
    found["changed"] = known["Hair"].lines
    hair.name = "Renamed"
    bpy.ops.hairpipe.simulate(name="Renamed")
    found["changed places"] = places(result, LAST).tolist()
    found["renamed"] = sorted(item.name for item in bpy.data.objects if item.type == "CURVES")
    saved = folder / "mit ä blank" / "done.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(saved))
    bpy.ops.hairpipe.remove()
    found["shown again"] = not hair.hide_viewport and not hair.hide_render
    found["left"] = [item.name for item in bpy.data.objects if item.type == "CURVES"]
    found["blocks"] = [len(bpy.data.hair_curves), len(bpy.data.cache_files)]
    return found


def scene_of_all(folder: Path) -> dict[str, Any]:
    """Two grooms, pins, a garment and a hidden collider in a scene in centimetres with gravity along X."""
    hair = make_scene(folder / "all.blend", scale=0.01)
    head = bpy.data.objects["Head"]
    head.animation_data_clear()
    other = make_hair(head, "Fringe", 0.01, seed=2)
    pinned = hair.data.attributes.new("tied", "BOOLEAN", "POINT")
    pinned.data.foreach_set("value", np.tile(np.arange(POINTS) == POINTS - 1, CURVES))
    bpy.ops.mesh.primitive_plane_add(size=60.0, location=(0.0, 0.0, -13.0))
    garment = bpy.context.object
    garment.name = "Garment"
    bpy.ops.mesh.primitive_cube_add(size=3.0, location=(0.0, 30.0, 0.0))
    hand = bpy.context.object
    hand.name, hand.hide_viewport, hand.scale = "Hand", True, (1.0, -2.0, 1.0)
    scene = bpy.context.scene
    scene.gravity = (9.81, 0.0, 0.0)
    own = hair.hairpipe
    for item, sheet in ((garment, True), (hand, False)):
        entry = own.colliders.add()
        entry.item, entry.sheet = item, sheet
    own.companions.add().item = other
    own.pins, own.preset, own.samples, own.preroll = "tied", "FINE", 2, 2
    own.use_rest, own.rest = True, FIRST
    other.data.attributes.new("tied", "BOOLEAN", "CURVE")
    bpy.ops.hairpipe.simulate(name="Hair")
    graph = next(folder.rglob("shot.toml")).read_text(encoding="utf-8")
    found = {"graph": graph, "hand": hand.hide_viewport, "results": {}}
    for item in (hair, other):
        result = item.hairpipe.result
        points = {time: places(result, time) for time in (FIRST, LAST)}
        start = places_of_original(item)
        found["results"][item.name] = {
            "roots": float(np.abs(points[FIRST][::POINTS] - start[::POINTS]).max()),
            "tips": (points[LAST][POINTS - 1 :: POINTS] - points[FIRST][POINTS - 1 :: POINTS]).mean(axis=0).tolist(),
        }
    return found


def places_of_original(item: Any) -> np.ndarray:
    bpy.context.scene.frame_set(FIRST)
    item.hide_viewport = False
    found = places(item, FIRST)
    item.hide_viewport = True
    return found


def particles(folder: Path) -> dict[str, Any]:
    """Simulate the hair of an old particle system."""
    hair = make_scene(folder / "shot.blend")
    head = hair.data.surface
    bpy.data.objects.remove(hair)
    system = head.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    system.type, system.count, system.hair_length, system.hair_step = "HAIR", 20, 0.1, 5
    bpy.context.view_layer.objects.active = head
    bpy.ops.hairpipe.simulate()
    curves = [item for item in bpy.data.objects if item.type == "CURVES"]
    found = {item.name: [len(item.data.curves), item.hide_render, len(item.modifiers)] for item in curves}
    return {"curves": found, "drawn": head.modifiers["hair"].show_render}


def modal(folder: Path) -> dict[str, Any]:
    """Drive a run by a timer, as Blender does with a screen: to the end, and to Esc in the middle."""
    from hairpipe_extension.operators import Driven, running
    from hairpipe_extension.simulation import known

    class Trial(Driven):
        verb, name = "simulate", "Hair"

        def report(self, kind: set[str], text: str) -> None:
            said.append(text)

    said: list[str] = []
    found: dict[str, Any] = {}
    for name, ticks in (("stopped", 60), ("whole", 100_000)):
        hair = make_scene(folder / "shot.blend")
        bpy.context.scene.frame_set(FIRST + 1)
        trial, context = Trial(), Screen()
        assert trial.invoke(context, None) == {"RUNNING_MODAL"}
        answer = {"PASS_THROUGH"}
        seen = 0.0
        for tick in range(100_000):
            time.sleep(0.01)
            event = SimpleNamespace(type="ESC" if tick == ticks else "TIMER", value="PRESS")
            answer = trial.modal(context, event)
            preview = bpy.data.objects.get("Hair (running)")
            if preview is not None:
                seen = float(np.abs(places(preview, FIRST + 1)).max())
            if answer != {"PASS_THROUGH"}:
                break
        curves = [item.name for item in bpy.data.objects if item.type == "CURVES"]
        shown = None if hair.hairpipe.result is None else float(np.abs(places(hair.hairpipe.result, FIRST + 1)).max())
        found[name] = [*answer, curves, seen, shown, len(running), known.get("Hair"), context.lines[-2:]]
    return found | {"said": said}


class Screen:
    """What an operator uses of the context of a window."""

    def __init__(self) -> None:
        self.lines: list[str | None] = []
        self.window_manager = self.workspace = self.screen = self.window = self
        self.areas: list[Any] = []
        self.object = bpy.data.objects["Hair"]
        self.scene, self.view_layer = bpy.context.scene, bpy.context.view_layer
        self.evaluated_depsgraph_get = bpy.context.evaluated_depsgraph_get

    def status_text_set(self, text: str | None) -> None:
        self.lines.append(text)

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *_, **__: None  # progress and timers of a window


def long_run(folder: Path) -> dict[str, Any]:
    """A run that the test kills."""
    hair = make_scene(folder / "shot.blend")
    bpy.context.scene.frame_end = FIRST + 99
    bpy.ops.wm.save_mainfile()
    bpy.ops.hairpipe.simulate(name=hair.name)
    return {}


def plan_again(folder: Path) -> dict[str, Any]:
    """What is left of a run that was killed."""
    from hairpipe_extension.simulation import known

    bpy.ops.wm.open_mainfile(filepath=str(folder / "shot.blend"))
    bpy.ops.hairpipe.check(name="Hair")
    return {"lines": known["Hair"].lines}


def faults(folder: Path) -> dict[str, Any]:
    """The message of each thing that cannot be simulated."""
    found: dict[str, str] = {}

    def trial(name: str, spoil: Callable[[Any], Any], file: Path | None = folder / "shot.blend") -> None:
        hair = make_scene(file)
        spoil(hair)
        with refused() as said:
            bpy.ops.hairpipe.simulate(name="Hair")
        found[name] = said[0] if said else ""

    def empty(hair: Any) -> None:
        surface = hair.data.surface
        hair.data = bpy.data.hair_curves.new("none")
        hair.data.surface = surface

    def linked(hair: Any) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"))
        bpy.ops.wm.read_factory_settings(use_empty=True)
        with bpy.data.libraries.load(str(folder / "library.blend"), link=True) as (_, into):
            into.objects = ["Hair"]
        bpy.context.scene.collection.objects.link(bpy.data.objects["Hair"])
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "uses.blend"))

    trial("unsaved", lambda hair: None, None)
    trial("no surface", lambda hair: setattr(hair.data, "surface", None))
    trial("no map", lambda hair: setattr(hair.hairpipe.simulation.material.young, "map", "nowhere"))
    trial("no list", lambda hair: setattr(hair.hairpipe.simulation.material.young, "profile", "steep"))
    trial("no pins", lambda hair: setattr(hair.hairpipe, "pins", "nowhere"))
    trial("linked", linked)
    trial("instances", lambda hair: setattr(hair.data.surface, "instance_type", "VERTS"))
    trial("no curves", empty)
    trial("far", lambda hair: setattr(hair, "location", (5.0, 0.0, 0.0)))
    with refused() as said:
        bpy.ops.hairpipe.simulate(name="Nobody")
    found["absent"] = said[0]
    from hairpipe_extension.simulation import close_bridge

    for name, program in (("no program", folder / "nowhere"), ("old program", old_program(folder))):
        close_bridge()
        os.environ["HAIRPIPE"] = str(program)
        trial(name, lambda hair: None)
    return found


def old_program(folder: Path) -> Path:
    path = folder / "old" / "hairpipe"
    path.parent.mkdir()
    path.write_text('#!/bin/sh\necho \'{"event": "hello", "protocol": 99, "hairpipe": "9.9"}\'\ncat >/dev/null\n')
    path.chmod(0o755)
    return path


def interface(folder: Path) -> dict[str, Any]:
    """Draw all panels with a layout that records, set every preset, and register a second time."""
    import hairpipe_extension
    from hairpipe_extension import panel, presets, properties
    from hairpipe_extension.settings import set_values, values_of

    hair = make_scene(folder / "shot.blend")
    found: dict[str, Any] = {"presets": {}, "panels": {}}
    for name, (_, _, wanted) in presets.PRESETS.items():
        hair.hairpipe.preset = name
        settings = properties.shown_settings("simulation")
        found["presets"][name] = [wanted, values_of(hair.hairpipe.simulation, settings, list)]
        set_values(hair.hairpipe.simulation, settings, {})
    hair.hairpipe.preset, hair.hairpipe.quality, hair.hairpipe.pins = "WET", "DRAFT", "clump"
    for one in properties.shown_settings("simulation"):
        if f"use_{one['name']}" in hair.hairpipe.simulation.bl_rna.properties:
            setattr(hair.hairpipe.simulation, f"use_{one['name']}", True)
    for one in panel.CLASSES:
        if hasattr(one, "draw"):
            self = Recorder()
            getattr(one, "draw_header", lambda self, context: None)(self, bpy.context)
            one.draw(self, bpy.context)
            found["panels"][one.__name__] = self.rows
    for _ in range(2):
        hairpipe_extension.unregister()
        hairpipe_extension.register()
    return found


class Recorder:
    """A layout that records what is drawn, and refuses properties that are not there."""

    def __init__(self, rows: list[str] | None = None) -> None:
        self.rows = [] if rows is None else rows

    @property
    def layout(self) -> "Recorder":
        return self

    def prop(self, data: Any, name: str, text: str | None = None, **_: Any) -> None:
        found = data.bl_rna.properties[name]
        self.rows.append(found.name if text is None else text)

    def prop_search(self, data: Any, name: str, *_: Any) -> None:
        self.prop(data, name)

    def label(self, text: str = "", **_: Any) -> None:
        self.rows.append(text)

    def operator(self, name: str, **_: Any) -> Any:
        group, _, verb = name.partition(".")
        assert getattr(getattr(bpy.ops, group), verb).get_rna_type()
        return type("Given", (), {})()

    def template_list(self, *_: Any, **__: Any) -> None:
        pass

    def panel(self, *_: Any, **__: Any) -> tuple["Recorder", "Recorder"]:
        return self, self

    def row(self, **_: Any) -> "Recorder":
        return Recorder(self.rows)

    column = box = row


def render(folder: Path) -> dict[str, Any]:
    """Render a saved scene by Cycles, as a farm without the extension does."""
    bpy.ops.wm.open_mainfile(filepath=str(folder / "mit ä blank" / "done.blend"))
    scene = bpy.context.scene
    scene.frame_set(FIRST + 2)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.0, -0.7, 0.05), (1.5, 0.0, 0.0)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 4.0
    for item in (camera, sun):
        scene.collection.objects.link(item)
    scene.camera, scene.render.engine, scene.cycles.samples = camera, "CYCLES", 16
    scene.render.resolution_x = scene.render.resolution_y = 96
    scene.render.use_motion_blur = True
    scene.render.filepath = str(folder / "picture.png")
    bpy.ops.render.render(write_still=True)
    return {"extension": "hairpipe" in bpy.types.Object.bl_rna.properties}


def main() -> None:
    case, folder, extension = sys.argv[1:4]
    if extension != "none":
        sys.path.insert(0, extension)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        import hairpipe_extension

        hairpipe_extension.register()
    try:
        found = globals()[case](Path(folder))
    finally:
        if extension != "none":
            hairpipe_extension.stop()
    print("\n" + json.dumps(found))


if __name__ == "__main__":
    main()
