"""Extension of Blender that simulates hair of a scene by hairpipe, which runs as a program of its own.

Copyright (C) 2026 the authors of hairpipe

This folder is free software: you can redistribute it and modify it under the terms of the GNU General Public License as
published by the Free Software Foundation, either version 3 of the License, or (at your option) any later version. It
runs in Blender, which is under that licence; nothing of hairpipe imports it. It is also under the Apache License 2.0.
"""

from typing import Any

import bpy
from bpy.props import PointerProperty, StringProperty


class HairpipePreferences(bpy.types.AddonPreferences):
    """Where hairpipe is."""

    bl_idname = __package__

    program: StringProperty(
        name="hairpipe",
        description="Program hairpipe, or the folder of its environment; by default it is looked for",
        subtype="FILE_PATH",
    )
    found: StringProperty()

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.prop(self, "program")
        row = layout.row()
        row.operator("hairpipe.try")
        row.operator("hairpipe.install")
        if self.found:
            layout.label(text=self.found)


def classes() -> list[type]:
    from . import operators, panel, properties

    return [HairpipePreferences, *properties.build_classes(), *operators.CLASSES, *panel.CLASSES]


registered: list[type] = []


def register() -> None:
    from .properties import HairProperties

    for one in classes():
        bpy.utils.register_class(one)
        registered.append(one)
    bpy.types.Object.hairpipe = PointerProperty(type=HairProperties, override={"LIBRARY_OVERRIDABLE"})


def stop() -> None:
    """End the program hairpipe, if it runs; what it has computed is kept."""
    from .simulation import close_bridge

    close_bridge()


def unregister() -> None:
    stop()
    del bpy.types.Object.hairpipe
    while registered:
        bpy.utils.unregister_class(registered.pop())
