"""The sidebar of the 3D view: Hair. Its rows are those of the declaration of the nodes, in the same groups."""

from typing import Any

import bpy

from .operators import hair_of, has_particles, running
from .properties import shown_settings
from .settings import Setting, fields_of, label_of, may_be_absent
from .simulation import known

OFTEN = ("material", "contact", "stiction", "collisions", "air", "wind", "goal")
"""Groups of the simulation with a panel of their own; the others are under Advanced."""


def draw_settings(layout: Any, group: Any, settings: list[Setting], box: Any = None) -> None:
    """Draw rows of settings; a group that is switched off is drawn as its switch alone.

    box  object whose attributes may be maps
    """
    for setting in settings:
        own = setting["name"]
        column = layout.column(align=True)
        shown = True
        if may_be_absent(setting):
            column.prop(group, f"use_{own}")
            shown = getattr(group, f"use_{own}")
        if not shown:
            continue
        if setting["group"]:
            fields = fields_of(setting)
            if may_be_absent(setting):
                column = column.box()
            elif fields[0]["name"] == "value":
                draw_varied(column, getattr(group, own), own, fields, box)
                continue
            else:
                column.label(text=label_of(own))
                column = column.box()
            draw_settings(column, getattr(group, own), fields, box)
        else:
            draw_value(column, group, setting, box)


def draw_varied(column: Any, group: Any, name: str, fields: list[Setting], box: Any) -> None:
    """Draw a value, and what varies it over the hair, folded in."""
    unit = group.bl_rna.properties["value"].name.partition("(")[2]
    column.prop(group, "value", text=label_of(name) + (f" ({unit}" if unit else ""))
    header, body = column.panel(f"HAIRPIPE_{group.bl_rna.identifier}", default_closed=True)
    header.label(text="Varied")
    if body is not None:
        for field in fields[1:]:
            draw_value(body, group, field, box)


def draw_value(layout: Any, group: Any, setting: Setting, box: Any) -> None:
    own = setting["name"]
    if own == "map" and box is not None:
        layout.prop_search(group, own, box.data, "attributes")
    elif may_be_absent(setting):
        layout.prop(group, own, text="")
    else:
        layout.prop(group, own)


class Side:
    """Where all panels are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Hair"

    @classmethod
    def poll(cls, context: Any) -> bool:
        item = hair_of(context)
        return item is not None and item.type == "CURVES"


class HAIRPIPE_PT_hair(bpy.types.Panel):
    bl_label = "Simulated Hair"
    bl_idname = "HAIRPIPE_PT_hair"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Hair"

    def draw(self, context: Any) -> None:
        layout = self.layout
        item = hair_of(context)
        if item is None or not (item.type == "CURVES" or has_particles(item)):
            layout.label(text="Select a hair curves object")
            return
        progress = next(iter(running.values()), None)
        if progress is not None:
            layout.progress(factor=progress.share, text=progress.text)
            layout.label(text="Esc stops; what is computed is kept")
            return
        row = layout.row(align=True)
        row.scale_y = 1.5
        row.operator("hairpipe.simulate", icon="PLAY")
        row.operator("hairpipe.check", text="", icon="VIEWZOOM")
        if item.type != "CURVES":
            layout.label(text="The particle system becomes hair curves")
            return
        own = item.hairpipe
        lines, current = known.get(item.name, ([], True))
        for line in lines:
            layout.label(text=line, icon="NONE" if current else "QUESTION")
        if not current:
            layout.label(text="Settings have changed since: Check counts again")
        if own.result is not None:
            layout.operator("hairpipe.remove", icon="TRASH")
        layout.use_property_split = True
        layout.prop(own, "preset")
        layout.prop(own, "quality")
        if own.quality == "DRAFT":
            layout.prop(own, "every")


class HAIRPIPE_PT_scene(Side, bpy.types.Panel):
    bl_label = "Body and Scene"
    bl_parent_id = "HAIRPIPE_PT_hair"

    def draw(self, context: Any) -> None:
        layout = self.layout
        item = hair_of(context)
        own = item.hairpipe
        layout.use_property_split = True
        layout.prop(own, "body")
        if own.body is None and item.data.surface is not None:
            layout.label(text=f"Body: {item.data.surface.name}")
        draw_list(layout, own, "colliders", "active_collider", "Colliders")
        if own.colliders:
            chosen = own.colliders[min(own.active_collider, len(own.colliders) - 1)]
            layout.prop(chosen, "sheet")
            if chosen.sheet:
                layout.prop(chosen, "thickness")
        layout.prop(own, "collection")
        draw_list(layout, own, "companions", "active_companion", "Other Hair")
        for name in ("wind", "use_rest"):
            layout.prop(own, name)
        if own.use_rest:
            layout.prop(own, "rest")
        for name in ("preroll", "samples"):
            layout.prop(own, name)
        layout.prop_search(own, "pins", item.data, "attributes")
        if own.pins:
            layout.prop(own, "pin_frequency")


def draw_list(layout: Any, own: Any, entries: str, active: str, label: str) -> None:
    layout.label(text=label)
    row = layout.row()
    row.template_list("HAIRPIPE_UL_objects", entries, own, entries, own, active, rows=2)
    column = row.column(align=True)
    for do, icon in (("add", "ADD"), ("remove", "REMOVE")):
        button = column.operator("hairpipe.list", text="", icon=icon)
        button.entries, button.do = entries, do


class HAIRPIPE_UL_objects(bpy.types.UIList):
    def draw_item(
        self, context: Any, layout: Any, data: Any, entry: Any, icon: int, holder: Any, name: str, index: int = 0
    ) -> None:
        layout.prop(entry, "item", text="")


def group_panel(name: str) -> type:
    """Return the panel of a group of the simulation; an optional group is switched in its header."""
    setting = next(one for one in shown_settings("simulation") if one["name"] == name)

    def draw_header(self: Any, context: Any) -> None:
        self.layout.prop(hair_of(context).hairpipe.simulation, f"use_{name}", text="")

    def draw(self: Any, context: Any) -> None:
        item = hair_of(context)
        layout = self.layout
        layout.use_property_split = True
        layout.active = not may_be_absent(setting) or getattr(item.hairpipe.simulation, f"use_{name}")
        draw_settings(layout, getattr(item.hairpipe.simulation, name), fields_of(setting), item)

    own = {
        "bl_label": label_of(name),
        "bl_parent_id": "HAIRPIPE_PT_hair",
        "bl_options": {"DEFAULT_CLOSED"},
        "draw": draw,
    }
    own |= {"draw_header": draw_header} if may_be_absent(setting) else {}
    return type(f"HAIRPIPE_PT_{name}", (Side, bpy.types.Panel), own)


class HAIRPIPE_PT_advanced(Side, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "HAIRPIPE_PT_hair"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context: Any) -> None:
        item = hair_of(context)
        layout = self.layout
        layout.use_property_split = True
        for name in ("roots", "surface", "interpolation", "simulation"):
            layout.label(text={"roots": "Curves", "surface": "Level set of the body"}.get(name, label_of(name)))
            settings = [one for one in shown_settings(name) if one["name"] not in OFTEN]
            draw_settings(layout.box(), getattr(item.hairpipe, name), settings, item)


CLASSES = (
    HAIRPIPE_UL_objects,
    HAIRPIPE_PT_hair,
    HAIRPIPE_PT_scene,
    *map(group_panel, OFTEN),
    HAIRPIPE_PT_advanced,
)
