"""What a .blend file keeps with a hair object: settings, colliders, the result."""

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import presets
from .scene import SURFACES
from .settings import COMMON, group_class, settings_of

NODES = {
    "simulation": "simulate_hair",
    "surface": "bake_levelset",
    "roots": "load_groom",
    "interpolation": "interpolate_hair",
}
"""Nodes whose settings an object has, by the name of the property."""
LEFT_OUT = {
    "surface": {"engine", "thickness"},
    "roots": {"file", "unit", "up", "time_code", "absent", "select", "points", "strands", "tips", "segment_length"},
    "simulation": {"volume"},
}
"""Settings that the extension sets itself, or that need more of a graph than it writes."""


def shown_settings(name: str) -> list[dict[str, Any]]:
    """Return the settings of a property that an artist sees."""
    return [one for one in settings_of(NODES[name]) if one["name"] not in LEFT_OUT.get(name, ())]


def touched(properties: Any, context: Any) -> None:
    """A setting has changed: what is known of the next run is not true any more."""
    from .simulation import forget_plan

    forget_plan(properties.id_data)


def is_surface(_: Any, item: Any) -> bool:
    return item.type in SURFACES


def is_hair(_: Any, item: Any) -> bool:
    return item.type == "CURVES"


class Collider(bpy.types.PropertyGroup):
    """An object that stops hair."""

    item: PointerProperty(name="Object", type=bpy.types.Object, poll=is_surface, update=touched, **COMMON)
    sheet: BoolProperty(
        name="Sheet",
        description="An open surface, such as a garment, that stops hair on either side; otherwise it is solid",
        update=touched,
        **COMMON,
    )
    thickness: FloatProperty(
        name="Thickness (mm)",
        description="Thickness of a sheet; 0: two voxels of the level set",
        min=0.0,
        max=100.0,
        update=touched,
        **COMMON,
    )


class Companion(bpy.types.PropertyGroup):
    """Another hair object of the shot."""

    item: PointerProperty(name="Hair", type=bpy.types.Object, poll=is_hair, update=touched, **COMMON)


def use_preset(properties: Any, _: Any) -> None:
    presets.apply(properties)


class HairProperties(bpy.types.PropertyGroup):
    """Settings of a shot, with the hair object that it is started from."""

    slug: StringProperty(
        description="Name of this object in the graph and in files; a new name does not change it", **COMMON
    )
    result: PointerProperty(type=bpy.types.Object, **COMMON)
    is_hidden: BoolProperty(**COMMON)
    was_hidden: BoolProperty(**COMMON)
    was_unrendered: BoolProperty(**COMMON)
    preset: EnumProperty(
        name="Preset", items=presets.ITEMS, update=use_preset, description="Kind of hair; sets the material and contact"
    )
    quality: EnumProperty(
        name="Quality",
        items=[
            ("FINAL", "Final", "All curves are simulated"),
            ("DRAFT", "Draft", "Some curves are simulated, and the others follow them"),
        ],
        update=touched,
        **COMMON,
    )
    every: IntProperty(
        name="One of", description="One of so many curves is simulated", default=10, min=2, max=1000, update=touched
    )
    body: PointerProperty(
        name="Body",
        type=bpy.types.Object,
        poll=is_surface,
        description="Object that carries the hair; by default the surface of the curves",
        update=touched,
        **COMMON,
    )
    colliders: CollectionProperty(type=Collider, **COMMON)
    active_collider: IntProperty()
    collection: PointerProperty(
        name="Collection",
        type=bpy.types.Collection,
        description="All surfaces in this collection stop hair, too; they are solid",
        update=touched,
        **COMMON,
    )
    companions: CollectionProperty(type=Companion, **COMMON)
    active_companion: IntProperty()
    use_rest: BoolProperty(
        name="Rest Frame",
        description="Hair lies as groomed at this frame; by default at the first one",
        update=touched,
        **COMMON,
    )
    rest: IntProperty(name="Frame", default=1, update=touched, **COMMON)
    preroll: IntProperty(
        name="Preroll",
        description="Frames before the first one in which the body moves from its rest to the first pose, and holds it",
        min=0,
        max=1000,
        update=touched,
        **COMMON,
    )
    samples: IntProperty(
        name="Samples",
        description="Samples of the body in a frame: more for motion that is fast within a frame",
        default=1,
        min=1,
        max=16,
        update=touched,
        **COMMON,
    )
    wind: BoolProperty(
        name="Wind of the Scene",
        description="Wind force fields act on hair; their strength is its velocity in m/s",
        default=True,
        update=touched,
        **COMMON,
    )
    pins: StringProperty(
        name="Pins",
        description="Attribute of points or curves; where it is above 0.5, hair is pinned to the body",
        update=touched,
        **COMMON,
    )
    pin_frequency: FloatProperty(
        name="Pin Frequency (Hz)",
        description="The higher, the harder the pins",
        default=200.0,
        min=0.1,
        max=1e4,
        update=touched,
        **COMMON,
    )


def build_classes() -> list[type]:
    """Return all property groups, inner ones first; those of nodes become fields of `HairProperties`."""
    made: list[type] = []
    for name in NODES:
        group = group_class(f"HAIRPIPE_{name}", shown_settings(name), touched, made)
        HairProperties.__annotations__[name] = PointerProperty(type=group, **COMMON)
    return [*made, Collider, Companion, HairProperties]
