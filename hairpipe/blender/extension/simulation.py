"""A run from press to result, as a generator: export, graph, run, curves. Who drives it decides how to wait.

An operator drives it by a timer, so that Blender stays usable, and a command line in a loop. Every step takes as long
as the export of one frame, or less.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np

from . import graph, results
from .bridge import Absent, Bridge, Event, find_program
from .files import pin_places, ply_of, usd_of, write
from .properties import NODES, shown_settings
from .scene import (
    SURFACES,
    Faces,
    Hair,
    Refused,
    axes_of,
    check_instances,
    gravity_of,
    read_faces,
    read_hair,
    shown,
    wind_of,
)
from .settings import values_of

PACKAGE = __package__ or "hairpipe"
LIVE = "live"
"""Folder of the frames that are shown while a run goes on."""


class Progress(NamedTuple):
    """How far a run is, 0 to 1, and what it does, in a line; idle: nothing to do but wait."""

    share: float
    text: str
    idle: bool = False


class Known(NamedTuple):
    """What is known of the next run of an object, in lines, and whether it is still true."""

    lines: list[str]
    current: bool = True


known: dict[str, Known] = {}
"""By the name of the hair object; not kept with the file."""
_bridges: list[Bridge] = []


def forget_plan(item: Any) -> None:
    """What is known of the next run of an object is not true any more."""
    if item.name in known:
        known[item.name] = known[item.name]._replace(current=False)


def preferences() -> Any:
    addon = bpy.context.preferences.addons.get(PACKAGE)
    return None if addon is None else addon.preferences


def own_environment() -> Path:
    """Return the folder for an environment of our own."""
    try:
        return Path(bpy.utils.extension_path_user(PACKAGE, path="environment"))
    except ValueError:  # not installed as an extension
        return Path(bpy.utils.user_resource("SCRIPTS", path="hairpipe")) / "environment"


def bridge() -> Bridge:
    """Return the process of hairpipe, which is started where there is none; Absent where that fails."""
    while _bridges and not _bridges[0].is_alive():
        _bridges.pop()
    if not _bridges:
        stated = preferences()
        _bridges.append(Bridge(find_program("" if stated is None else stated.program, own_environment())))
    return _bridges[0]


def close_bridge() -> None:
    """End the process of hairpipe, if there is one; what it has computed is kept."""
    while _bridges:
        _bridges.pop().close()


def folder_of(item: Any) -> Path:
    """Return the folder of the shot of a hair object, next to the .blend file; Refused for one that is not saved."""
    if not bpy.data.filepath:
        raise Refused("save the file first: the simulated hair lies next to it")
    blend = Path(bpy.data.filepath)
    return blend.parent / "hairpipe" / blend.stem / item.hairpipe.slug


def name_objects(items: list[Any]) -> None:
    """Give objects names for files and nodes, which stay when they are renamed; a copied object gets one of its own."""
    taken = {o.hairpipe.slug for o in bpy.data.objects if o.hairpipe.slug and o not in items}
    for item in items:
        if not item.hairpipe.slug or item.hairpipe.slug in taken:
            plain = re.sub(r"[^a-z0-9]+", "_", item.name.lower()).strip("_") or "hair"
            plain = plain if plain[0].isalpha() else f"hair_{plain}"
            numbers = ("", *(f"_{n}" for n in range(2, 10_000)))
            item.hairpipe.slug = next(plain + n for n in numbers if plain + n not in taken)
        taken.add(item.hairpipe.slug)


class Inputs(NamedTuple):
    """The objects of a shot."""

    hairs: list[Any]
    body: Any
    colliders: list[tuple[Any, bool, float]]

    @property
    def all(self) -> list[Any]:
        return [*self.hairs, self.body, *(item for item, _, _ in self.colliders)]


def inputs_of(item: Any) -> Inputs:
    """Return the objects of the shot of a hair object; Refused, in one line, where they cannot be used."""
    own = item.hairpipe
    hairs = [item, *(c.item for c in own.companions if c.item is not None and c.item != item)]
    for one in hairs:
        if one.type != "CURVES":
            raise Refused(f"{one.name} is not a hair curves object: convert its particle system first")
        if one.library is not None:
            raise Refused(f"{one.name} is linked: make a library override of it first")
    bodies = {b for b in (own.body or one.data.surface for one in hairs) if b is not None}
    if not bodies:
        raise Refused(f"{item.name} has no surface: pick a body in the panel")
    if len(bodies) > 1:
        names = ", ".join(sorted(body.name for body in bodies))
        raise Refused(f"the hair objects are on different surfaces, {names}: simulate them one after the other")
    body = bodies.pop()
    listed = [(c.item, c.sheet, 1e-3 * c.thickness) for c in own.colliders if c.item is not None]
    within = own.collection.all_objects if own.collection is not None else ()
    listed += [(one, False, 0.0) for one in within if one.type in SURFACES and one not in [i for i, _, _ in listed]]
    return Inputs(hairs, body, [row for row in listed if row[0] != body])


def maps_in(values: Any) -> set[str]:
    """Return the names of all maps in the settings of nodes."""
    if not isinstance(values, dict):
        return set()
    own = {values["map"]} if isinstance(values.get("map"), str) else set()
    return own.union(*(maps_in(inner) for inner in values.values()))


class Export:
    """Writes what hairpipe reads of a scene to the folder of a shot; `steps` writes a frame at a time."""

    def __init__(self, context: Any, item: Any) -> None:
        self.context, self.item = context, item
        self.scene = context.scene
        self.inputs = inputs_of(item)
        name_objects(self.inputs.all)
        self.folder = folder_of(item)
        self.axes = axes_of(self.scene)
        self.values = {
            name: values_of(getattr(item.hairpipe, name), shown_settings(name), self.axes.vector) for name in NODES
        }
        self.warnings: list[str] = []

    @property
    def cache(self) -> Path:
        """Folder of the results of all shots of the .blend files of a folder."""
        return self.folder.parent.parent / "cache"

    @property
    def file(self) -> Path:
        """Path of the graph."""
        return self.folder / "shot.toml"

    def steps(self) -> Iterator[Progress]:
        """Write all files; the scene is at its frame again afterwards. Refused and OSError end it."""
        scene = self.scene
        own = self.item.hairpipe
        now = scene.frame_current, scene.frame_subframe
        first, last = scene.frame_start, scene.frame_end
        rest = own.rest if own.use_rest else first
        try:
            with shown(self.context, self.inputs.all):
                scene.frame_set(rest)
                begin = self.write_rest()
                self.shot = self.describe(first - own.preroll, last)
                yield Progress(0.0, "hair and body at rest")
                times = np.arange((last - first) * own.samples + 1) / own.samples + first
                early = own.preroll * own.samples
                for number, time in enumerate(times):
                    scene.frame_set(int(time), subframe=float(time - int(time)))
                    faces = self.write_sample(early + number)
                    if number == 0 and early:
                        self.write_preroll(begin, faces, early)
                    yield Progress((number + 1) / len(times), f"frame {time:g} of {last}")
                self.discard_others(early + len(times))
        finally:
            scene.frame_set(now[0], subframe=now[1])

    def write_rest(self) -> dict[str, Faces]:
        """Write hair and body at rest; return the surfaces."""
        depsgraph = self.context.evaluated_depsgraph_get()
        check_instances(self.inputs.all, depsgraph)
        surfaces = {name: read_faces(item, depsgraph, self.axes) for name, item in self.surfaces().items()}
        self.put("body/rest.ply", ply_of(surfaces["body"]))
        wanted = sorted(maps_in(self.values))
        self.pins = {}
        self.read: dict[str, Hair] = {}
        for item in self.inputs.hairs:
            hair = read_hair(item, depsgraph, self.axes, self.inputs.body, wanted, self.item.hairpipe.pins)
            groups, self.pins[item.hairpipe.slug] = pin_places(hair)
            self.put(f"curves/{item.hairpipe.slug}.usda", usd_of(hair, []))
            if groups:  # in a file of its own: of a result with names Blender would warn at every frame
                self.put(f"curves/{item.hairpipe.slug}.pins.usda", usd_of(hair, groups))
            self.read[item.hairpipe.slug] = hair
            if hair.omitted:
                self.warnings.append(f"{item.name}: {hair.omitted} curves of one point or no length are left out")
        return surfaces

    def surfaces(self) -> dict[str, Any]:
        """Return the surfaces of the shot, by the names of their folders."""
        return {"body": self.inputs.body} | {
            f"collider_{item.hairpipe.slug}": item for item, _, _ in self.inputs.colliders
        }

    def write_sample(self, number: int) -> dict[str, Faces]:
        depsgraph = self.context.evaluated_depsgraph_get()
        found = {name: read_faces(item, depsgraph, self.axes) for name, item in self.surfaces().items()}
        for name, faces in found.items():
            self.put(f"{name}/{name}.{number:04d}.ply", ply_of(faces))
        return found

    def write_preroll(self, rest: dict[str, Faces], first: dict[str, Faces], count: int) -> None:
        """Write the samples before the first frame: from the rest to the first pose in the first half, then still."""
        for name, faces in first.items():
            if len(rest[name].points) != len(faces.points):
                raise Refused(
                    f"{name}: the mesh at rest has {len(rest[name].points)} vertices, not {len(faces.points)}"
                )
            for number in range(count):
                share = min(1.0, 2.0 * number / count)
                share = share * share * (3.0 - 2.0 * share)
                points = (1.0 - share) * rest[name].points + share * faces.points
                self.put(f"{name}/{name}.{number:04d}.ply", ply_of(faces._replace(points=points)))

    def put(self, name: str, content: bytes) -> None:
        write(self.folder / name, content)

    def discard_others(self, count: int) -> None:
        """Remove samples of a longer shot: a sequence is all files of its name."""
        for name in self.surfaces():
            for path in (self.folder / name).glob(f"{name}.*.ply"):
                if int(path.suffixes[-2][1:]) >= count:
                    path.unlink()

    def describe(self, first: int, last: int) -> graph.Shot:
        """Return what the graph depends on; gravity and wind are those of the scene."""
        own = self.item.hairpipe
        scene = self.scene
        simulation = dict(self.values["simulation"])
        gravity = gravity_of(scene)
        if gravity != 9.81:
            simulation["gravity"] = gravity
        wind = wind_of(scene) if own.wind else None
        if wind is not None:
            simulation["wind"] = simulation.get("wind", {}) | {"velocity": self.axes.vector(wind)}
        return graph.Shot(
            [graph.HairObject(o.hairpipe.slug, o.name, self.pins[o.hairpipe.slug]) for o in self.inputs.hairs],
            self.inputs.body.name,
            [graph.Collider(o.hairpipe.slug, o.name, sheet, thick) for o, sheet, thick in self.inputs.colliders],
            first,
            last,
            scene.render.fps / float(f"{scene.render.fps_base:.6g}"),
            own.samples,
            self.values["roots"],
            self.values["surface"],
            simulation,
            self.values["interpolation"],
            {} if own.pin_frequency == 200.0 else {"frequency": float(f"{own.pin_frequency:.6g}")},
            own.every if own.quality == "DRAFT" else 1,
        )


class Failed(Exception):
    """A run failed; the message names the object of Blender that it concerns."""


class Run:
    """Export, graph, and a request to hairpipe: `plan` for what would be computed, or `run`.

    is_live  whether frames are shown as they arrive
    """

    def __init__(self, context: Any, item: Any) -> None:
        """Refused where the objects cannot be used, Absent without hairpipe."""
        self.context, self.item_name = context, item.name
        self.export = Export(context, item)
        self.bridge = bridge()
        self.request: int | None = None
        self.is_live = False
        self.previews: dict[str, results.Preview] = {}
        self.warnings: list[str] = self.export.warnings

    def write_graph(self) -> Iterator[Progress]:
        for step in self.export.steps():
            yield step._replace(share=0.2 * step.share, text=f"Reading the scene: {step.text}")
        shot = self.export.shot
        self.tables = graph.tables_of(shot)
        fields = {"head": graph.head_of(shot), "tables": self.tables, "owned": graph.OWNED}
        yield from self.wait(self.bridge.ask("write", graph=str(self.export.file), **fields))

    def wait(self, number: int) -> Iterator[Progress]:
        """Give progress until a request is answered; its last event is `answer`. Failed for an error."""
        self.answer: Event = {}
        progress = Progress(0.2, "Waiting for hairpipe", idle=True)
        while not self.answer:
            for event in self.bridge.events():
                if event.get("id") == number:
                    progress = self.take(event, progress)
            yield progress

    def take(self, event: Event, progress: Progress) -> Progress:
        """Use an event of hairpipe; Failed for an error."""
        kind = event["event"]
        if kind in ("error", "failed"):
            raise Failed(self.message_of(event))
        if kind == "warning":
            self.warnings.append(self.message_of(event))
        elif kind == "frame":
            self.show(event)
        elif kind == "progress" and event["total"]:
            left = event.get("seconds_left")
            text = f"Frame {event['frame']}" if event.get("frame") is not None else "Values of the shot"
            text += f": {event['node']}" + (f", {clock(left)} left" if left is not None else "")
            return Progress(0.2 + 0.8 * event["done"] / event["total"], text, idle=True)
        elif kind == "done":
            self.answer = event
        return progress

    def message_of(self, event: Event) -> str:
        """Return a message of hairpipe with the name of the object of Blender that it concerns."""
        node = event.get("node")
        shot = getattr(self.export, "shot", None)
        name = graph.object_of(node, shot) if node and shot else self.item_name
        what = event.get("what") or event.get("message") or "it says nothing"
        frame = "" if event.get("frame") is None else f", frame {event['frame']}"
        right = f": {event['right']}" if event.get("right") else ""
        setting = f" ({event['setting']})" if event.get("setting") else ""
        return f"{name}{frame}: {what}{right}{setting}"

    def plan(self) -> Iterator[Progress]:
        """Find what a run would compute, and why; `known` has it in lines afterwards.

        Bodies and curves are read first: what they are decides which frames stand.
        """
        yield from self.write_graph()
        read = [n for n, table in self.tables.items() if table["type"].startswith("load_")]
        yield from self.wait(self.bridge.ask("run", graph=str(self.export.file), **self.where() | {"to": read}))
        yield from self.wait(self.bridge.ask("plan", graph=str(self.export.file), **self.where()))
        known[self.item_name] = Known(self.lines_of(self.answer))

    def where(self) -> dict[str, Any]:
        return {"cache": str(self.export.cache), "to": self.targets()}

    def targets(self) -> list[str]:
        return [f"usd_{item.slug}" for item in self.export.shot.hairs]

    def lines_of(self, plan: Event) -> list[str]:
        frames = plan.get("frames_to_run", {}).get("hair")
        if not sum(plan.get("to_run", {}).values()):
            return ["Nothing to compute: the result is current"]
        if not frames:
            return ["No frame to simulate; files are written"]
        expected = plan.get("seconds")
        return [f"Frames to simulate: {frames}"] + ([] if expected is None else [f"Expected: {clock(expected)}"])

    def simulate(self) -> Iterator[Progress]:
        """Compute what has changed, and attach the results."""
        results.discard_previews()
        yield from self.write_graph()
        live = {f"shown_{item.slug}": str(self.export.folder / LIVE / item.slug) for item in self.export.shot.hairs}
        self.request = self.bridge.ask("run", graph=str(self.export.file), live=live, **self.where())
        try:
            yield from self.wait(self.request)
        finally:
            self.request = None
            self.close_previews()
        if self.answer.get("exit_code"):
            raise Failed("hairpipe was stopped: what is computed is kept")
        for item in self.export.shot.hairs:
            original = self.original(item.name)
            usd = self.export.folder / f"{item.slug}.usdc"
            read = self.export.read[item.slug]
            if original is not None:
                results.attach(self.context.scene, original, usd, self.export.axes, read.ids)
        known[self.item_name] = Known(["Nothing to compute: the result is current"])

    def original(self, name: str) -> Any:
        """Return an object by its name when the run began: it may be gone, or replaced by undo."""
        return bpy.data.objects.get(name)

    def show(self, event: Event) -> None:
        """Show a frame that has arrived, if the scene is there."""
        slug = event["node"].partition("_")[2]
        name = next(item.name for item in self.export.shot.hairs if item.slug == slug)
        original = self.original(name)
        read = self.export.read[slug]
        if not self.is_live or original is None:
            return
        if slug not in self.previews:
            sizes = read.sizes.tolist()
            preview = results.Preview(self.context.scene, original, len(read.points), sizes, self.export.axes)
            self.previews[slug] = preview
        self.previews[slug].arrive(event["frame"], Path(event["file"]), event["points"])
        if event["frame"] == self.context.scene.frame_current:
            self.show_frame(event["frame"])

    def show_frame(self, frame: int) -> None:
        for preview in self.previews.values():
            preview.show(frame)

    def close_previews(self) -> None:
        self.previews.clear()
        results.discard_previews()

    def cancel(self) -> None:
        """Stop; what is computed is kept."""
        if self.request is not None:
            self.bridge.ask("cancel", run=self.request)
        self.close_previews()


def clock(seconds: float) -> str:
    """Return a time as people write it."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60}:{whole % 60:02d} min" if whole < 3600 else f"{whole // 3600}:{whole // 60 % 60:02d} h"


FAULTS = (Refused, Absent, Failed, OSError, RuntimeError, ValueError)
"""What ends a run with a message."""
