"""Settings of nodes as properties of Blender, made from `declaration.json`, and back as values of a graph.

Numbers are shown in the unit in which their default is between 0.1 and 100 or so: 80e-6 m is shown as 80 um. The graph
gets what differs from the defaults, and the groups that are switched on.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

Setting = dict[str, Any]
Turn = Callable[[list[float]], list[float]]
DECLARATION: dict[str, Any] = json.loads(Path(__file__).with_name("declaration.json").read_text(encoding="utf-8"))
"""The version of hairpipe that it is of, and what `hairpipe nodes TYPE --json` prints of each type."""
PREFIXES = ((1e-6, "u"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"), (1e9, "G"))
PREFIXED = ("m", "s", "N", "Pa")
"""Units of which parts and multiples are shown."""
VARIED = re.compile(r"a number in (\S+) or a group")
VECTOR = re.compile(r"a list, (\d) of: a number(?: in (.+))?")
COMMON: dict[str, Any] = {"override": {"LIBRARY_OVERRIDABLE"}}
LARGEST = 2**31 - 1


class Scale(NamedTuple):
    """Name of the unit in which a number is shown, and its size in the unit of the graph."""

    unit: str
    size: float


def scale_of(setting: Setting) -> Scale:
    """Return the largest unit in which the default of a setting is 0.1 or more."""
    unit = setting["unit"] or ""
    default = setting.get("like", setting["default"])
    if unit not in PREFIXED or not default:
        return Scale("" if unit == "1" else unit, 1.0)
    size, prefix = max((pair for pair in PREFIXES if abs(default) / pair[0] >= 0.1), default=PREFIXES[0])
    return Scale(prefix + unit, size)


def fields_of(setting: Setting) -> list[Setting]:
    """Return the fields of a group; both ends of what a map varies are shown in one unit, that of its number."""
    number = VARIED.match(setting["kind"])
    if not number:
        return setting["group"]
    shown = {"unit": number[1], "like": setting["group"][0]["default"]}
    return [field | shown if field["name"] in ("value", "low") else field for field in setting["group"]]


def may_be_absent(setting: Setting) -> bool:
    """Whether a property `use_NAME` says whether there is a value: an empty text says so by itself."""
    return setting["optional"] and setting["kind"] not in ("a text", "a file")


def settings_of(node: str) -> list[Setting]:
    """Return the settings that a node type declares."""
    return DECLARATION["types"][node]["settings"]


def label_of(name: str, unit: str = "") -> str:
    """Return the label of a setting, with its unit if it has one."""
    words = name.replace("_", " ").capitalize()
    return f"{words} ({unit})" if unit else words


def description_of(setting: Setting) -> str:
    """Return the help of a setting as Blender writes tooltips: with a capital, without a full stop."""
    text = setting["help"]
    return text[:1].upper() + text[1:].rstrip(".")


def limits_of(setting: Setting, size: float) -> dict[str, float]:
    """Return `min` and `max` of a property from the range of a setting, such as '> 0, <= 1'."""
    bounds = re.findall(r"([<>])=? ([-+.e\d]+)", setting["range"])
    return {"min" if sign == ">" else "max": float(number) / size for sign, number in bounds}


def property_of(setting: Setting, touched: Callable) -> Any:
    """Return the property of Blender for a setting without fields."""
    kind, default = setting["kind"], setting["default"]
    scale = scale_of(setting)
    limits = limits_of(setting, scale.size)
    given = {"name": label_of(setting["name"], scale.unit), "description": description_of(setting), "update": touched}
    given |= COMMON
    if kind == "a number":
        first = limits.get("min", 0.0) if default is None else default / scale.size
        return FloatProperty(default=first, precision=4, **limits, **given)
    if kind == "a whole number":
        whole = {name: max(-LARGEST, min(LARGEST, int(bound))) for name, bound in limits.items()}
        return IntProperty(default=whole.get("min", 0) if default is None else default, **whole, **given)
    if kind == "true or false":
        return BoolProperty(default=bool(default), **given)
    if kind.startswith("one of "):
        names = re.findall(r"'([^']+)'", kind)
        items = [(name, label_of(name), "") for name in names]
        return EnumProperty(items=items, default=names[0] if default is None else default, **given)
    if vector := VECTOR.match(kind):
        given["name"] = label_of(setting["name"], vector[2] or "")
        return FloatVectorProperty(size=int(vector[1]), default=default, **given)
    return StringProperty(subtype="FILE_PATH" if kind == "a file" else "NONE", **given)


def group_class(name: str, settings: list[Setting], touched: Callable, made: list[type]) -> type:
    """Return a property group for settings. It is appended to `made`, after those within it."""
    fields: dict[str, Any] = {}
    for setting in settings:
        own = setting["name"]
        about = {"description": description_of(setting)} | COMMON
        if may_be_absent(setting):
            fields[f"use_{own}"] = BoolProperty(name=label_of(own), update=touched, **about)
        if setting["group"]:
            inner = group_class(f"{name}_{own}", fields_of(setting), touched, made)
            fields[own] = PointerProperty(type=inner, name=label_of(own), **about)
        else:
            fields[own] = property_of(setting, touched)
    made.append(type(name, (bpy.types.PropertyGroup,), {"__annotations__": fields}))
    return made[-1]


def values_of(group: Any, settings: list[Setting], turn: Turn) -> dict[str, Any]:
    """Return what differs from the defaults, as values of a graph.

    turn  turns a vector of Blender's world into the axes of the graph
    Raises ValueError, with the name of the setting, for a text that is not a list.
    """
    found: dict[str, Any] = {}
    for setting in settings:
        own = setting["name"]
        if may_be_absent(setting) and not getattr(group, f"use_{own}"):
            continue
        if setting["group"]:
            inner = values_of(getattr(group, own), fields_of(setting), turn)
            if inner or setting["optional"]:
                found[own] = inner["value"] if inner.keys() == {"value"} else inner
        else:
            value = value_of(getattr(group, own), setting, turn)
            if value is not None and (value != setting["default"] or may_be_absent(setting)):
                found[own] = value
    return found


def value_of(shown: Any, setting: Setting, turn: Turn) -> Any:
    """Return what a property shows as the value of a setting; None for an empty text."""
    kind, default = setting["kind"], setting["default"]
    if kind == "a number":
        return in_graph(shown, scale_of(setting), default)
    if VECTOR.match(kind):
        return turn([in_graph(number, Scale("", 1.0), None) for number in shown])
    if kind == "a file":
        return bpy.path.abspath(shown) or None
    if kind.startswith("a list") and shown.strip():
        try:
            return json.loads(shown)
        except ValueError:
            raise ValueError(f"{setting['name']}: {shown[:60]} is not a list such as [[0, 1], [1, 0.5]]") from None
    return None if shown == "" else shown


def in_graph(shown: float, scale: Scale, default: float | None) -> float:
    """Return a number in the unit of the graph, with the digits of single precision that Blender keeps."""
    value = float(f"{shown:.6g}e{round_power(scale.size)}")
    if default is not None and abs(value - default) <= 1e-6 * abs(default):
        return default
    return value


def round_power(size: float) -> int:
    return int(f"{size:.0e}".partition("e")[2])


def set_values(group: Any, settings: list[Setting], values: Any) -> None:
    """Set properties to values of a graph, and all others to their defaults; a plain value is that of a group."""
    values = values if isinstance(values, dict) else {"value": values}
    for setting in settings:
        own = setting["name"]
        if may_be_absent(setting):
            setattr(group, f"use_{own}", own in values)
        if setting["group"]:
            set_values(getattr(group, own), fields_of(setting), values.get(own, {}))
        elif own in values:
            size = scale_of(setting).size if setting["kind"] == "a number" else 0
            setattr(group, own, values[own] / size if size else values[own])
        else:
            group.property_unset(own)
