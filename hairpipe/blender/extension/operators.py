"""What the buttons of the panel do; each is an operator, for scripts and for Blender without a screen, too."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from . import results, simulation
from .bridge import find_program, version_of
from .simulation import FAULTS, Progress, Run

TICK = 0.05
"""Time between looks at a run [s]."""
LONGEST = 0.02
"""Time for the steps of one look [s]; a step is at most the export of a frame."""
running: dict[str, Progress] = {}
"""Progress of the run that goes on, by the name of its object."""


def hair_of(context: Any, name: str = "") -> Any:
    """Return the named object, or the active one; of a result the hair object that it is of."""
    item = bpy.data.objects.get(name) if name else context.object
    if item is None:
        return None
    return next((o for o in bpy.data.objects if o.type == "CURVES" and o.hairpipe.result == item), item)


def convert_particles(context: Any, item: Any) -> Any:
    """Return hair curves made from the active hair particle system of an object, which is hidden."""
    known = set(bpy.data.objects)
    with context.temp_override(object=item, active_object=item, selected_objects=[item]):
        bpy.ops.curves.convert_from_particle_system()
    made = next(o for o in bpy.data.objects if o not in known)
    made.data.surface = made.data.surface or item
    settings = item.particle_systems.active.settings
    if 0 < settings.material <= len(item.material_slots) and not made.data.materials:
        made.data.materials.append(item.material_slots[settings.material - 1].material)
    for modifier in item.modifiers:
        if modifier.type == "PARTICLE_SYSTEM" and modifier.particle_system.settings == settings:
            modifier.show_viewport = modifier.show_render = False
    return made


def has_particles(item: Any) -> bool:
    """Whether an object has hair of a particle system."""
    return item.type == "MESH" and any(system.settings.type == "HAIR" for system in item.particle_systems)


class Driven:
    """An operator that drives a run: by a timer with a screen, in a loop without one.

    verb  what the run does: its method `simulate` or `plan`
    """

    verb: str
    name: StringProperty(name="Hair", description="Name of the hair object; by default the active one")

    @classmethod
    def poll(cls, context: Any) -> bool:
        return not running

    def start(self, context: Any) -> Any:
        """Return the hair object, or None after a report."""
        item = hair_of(context, self.name)
        if item is not None and has_particles(item):
            item = convert_particles(context, item)
        if item is None or item.type != "CURVES":
            what = f"there is no object '{self.name}'" if self.name and item is None else "no hair object is picked"
            self.report({"ERROR"}, f"{what}: select a hair curves object")
            return None
        try:
            self.run = Run(context, item)
        except FAULTS as fault:
            self.report({"ERROR"}, f"{item.name}: {fault}")
            return None
        self.driver: Iterator[Progress] = getattr(self.run, self.verb)()
        return item

    def execute(self, context: Any) -> set[str]:
        """Run to the end."""
        item = self.start(context)
        if item is None:
            return {"CANCELLED"}
        shown = ""
        try:
            for progress in self.driver:
                if progress.idle:
                    time.sleep(TICK)
                line = f"{100 * progress.share:3.0f} % {progress.text}"
                if line != shown and bpy.app.background:
                    print(line, flush=True)
                shown = line
        except FAULTS as fault:
            return self.fail(fault)
        except BaseException:
            self.run.cancel()
            raise
        return self.finish()

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Run next to the work of the user, who can end it by Esc."""
        item = self.start(context)
        if item is None:
            return {"CANCELLED"}
        self.item = item.name
        self.run.is_live = True
        running[self.item] = Progress(0.0, "Begins")
        manager = context.window_manager
        manager.progress_begin(0, 1000)
        self.timer = manager.event_timer_add(TICK, window=context.window)
        bpy.app.handlers.frame_change_post.append(self.show_frame)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def show_frame(self, scene: Any, *_: Any) -> None:
        self.run.show_frame(scene.frame_current)

    def modal(self, context: Any, event: Any) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self.run.cancel()
            self.driver.close()
            self.end(context)
            self.report({"WARNING"}, "Stopped: what is computed is kept")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        begun = time.monotonic()
        try:
            progress = next(self.driver)
            while not progress.idle and time.monotonic() - begun < LONGEST:
                progress = next(self.driver)
        except StopIteration:
            self.end(context)
            return self.finish()
        except FAULTS as fault:
            self.end(context)
            return self.fail(fault)
        running[self.item] = progress
        context.window_manager.progress_update(1000 * progress.share)
        context.workspace.status_text_set(f"Hair {100 * progress.share:.0f} %  {progress.text}   Esc: stop")
        for area in context.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
        return {"PASS_THROUGH"}

    def cancel(self, context: Any) -> None:
        """Stop when Blender ends the operator, as it does to load a file."""
        running.clear()
        self.run.cancel()
        self.driver.close()

    def end(self, context: Any) -> None:
        running.clear()
        if self.show_frame in bpy.app.handlers.frame_change_post:
            bpy.app.handlers.frame_change_post.remove(self.show_frame)
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def fail(self, fault: Exception) -> set[str]:
        self.run.cancel()
        self.report({"ERROR"}, str(fault))
        return {"CANCELLED"}

    def finish(self) -> set[str]:
        for line in dict.fromkeys(self.run.warnings):
            self.report({"WARNING"}, line)
        return {"FINISHED"}


class HAIRPIPE_OT_simulate(Driven, bpy.types.Operator):
    """Simulate hair over the frames of the scene; only what has changed is computed again"""

    bl_idname = "hairpipe.simulate"
    bl_label = "Simulate"
    bl_options = {"REGISTER"}  # noqa: RUF012 - as Blender wants it
    verb = "simulate"


class HAIRPIPE_OT_check(Driven, bpy.types.Operator):
    """Read the scene, and say how many frames Simulate would compute, and how long that takes"""

    bl_idname = "hairpipe.check"
    bl_label = "Check"
    bl_options = {"REGISTER"}  # noqa: RUF012
    verb = "plan"


class HAIRPIPE_OT_remove(bpy.types.Operator):
    """Remove the simulated hair, and show the original again; files are kept"""

    bl_idname = "hairpipe.remove"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    name: StringProperty(name="Hair", description="Name of the hair object; by default the active one")

    @classmethod
    def poll(cls, context: Any) -> bool:
        return not running

    def execute(self, context: Any) -> set[str]:
        item = hair_of(context, self.name)
        if item is None or item.hairpipe.result is None:
            self.report({"ERROR"}, "there is no simulated hair")
            return {"CANCELLED"}
        results.remove(item)
        return {"FINISHED"}


class HAIRPIPE_OT_list(bpy.types.Operator):
    """Add the selected objects to a list, or remove the active entry"""

    bl_idname = "hairpipe.list"
    bl_label = "Change List"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    entries: StringProperty()
    do: StringProperty()

    def execute(self, context: Any) -> set[str]:
        own = hair_of(context).hairpipe
        entries = getattr(own, self.entries)
        active = "active_collider" if self.entries == "colliders" else "active_companion"
        if self.do == "remove":
            entries.remove(getattr(own, active))
            setattr(own, active, max(0, getattr(own, active) - 1))
            return {"FINISHED"}
        wanted = (lambda o: o.type == "CURVES") if self.entries == "companions" else (lambda o: o.type == "MESH")
        listed = [entry.item for entry in entries]
        for item in context.selected_objects:
            if wanted(item) and item != own.id_data and item not in listed:
                entries.add().item = item
        return {"FINISHED"}


class HAIRPIPE_OT_try(bpy.types.Operator):
    """Start hairpipe, and show its version"""

    bl_idname = "hairpipe.try"
    bl_label = "Try"

    def execute(self, context: Any) -> set[str]:
        stated = simulation.preferences()
        try:
            program = find_program("" if stated is None else stated.program, simulation.own_environment())
            about = version_of(program)
        except FAULTS as fault:
            self.report({"ERROR"}, str(fault))
            return {"CANCELLED"}
        found = f"{about.splitlines()[0]}, {program}"
        if stated is not None:
            stated.found = found
        self.report({"INFO"}, found)
        return {"FINISHED"}


class HAIRPIPE_OT_install(bpy.types.Operator):
    """Make an environment for hairpipe from its wheel; wheels of its libraries lie in the same folder"""

    bl_idname = "hairpipe.install"
    bl_label = "Install from Wheel"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="hairpipe-*.whl", options={"HIDDEN"})

    def invoke(self, context: Any, event: Any) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        wheel = Path(self.filepath)
        place = simulation.own_environment()
        if not wheel.is_file():
            self.report({"ERROR"}, f"{wheel} is not a file: pick hairpipe-VERSION-py3-none-any.whl")
            return {"CANCELLED"}
        python = place / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
        pip = [python, "-m", "pip", "install", "--no-index", "--find-links", wheel.parent, wheel]
        for line in ([sys.executable, "-m", "venv", "--clear", place], pip):
            done = subprocess.run(list(map(str, line)), capture_output=True, text=True, check=False)
            if done.returncode:
                last = (done.stderr.strip().splitlines() or ["no message"])[-1]
                right = f"put the wheels of its libraries into {wheel.parent}: pip download -d FOLDER {wheel.name}"
                self.report({"ERROR"}, f"{last}: {right}")
                return {"CANCELLED"}
        simulation.close_bridge()
        return getattr(bpy.ops.hairpipe, "try")()


CLASSES = (
    HAIRPIPE_OT_simulate,
    HAIRPIPE_OT_check,
    HAIRPIPE_OT_remove,
    HAIRPIPE_OT_list,
    HAIRPIPE_OT_try,
    HAIRPIPE_OT_install,
)
