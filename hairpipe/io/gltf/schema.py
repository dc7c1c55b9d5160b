"""Members of the JSON of a glTF file that are read, and the values that each may have.

Readers of a checked JSON need no checks of their own: its indices exist, and its numbers are finite. Members that are
null are left out, and all others that are not listed here are ignored.

Source: glTF 2.0 Specification, Khronos Group 2021, 5: Properties Reference.
"""

from pathlib import Path
from typing import Any, NamedTuple

from hairpipe.errors import BadInput
from hairpipe.io.text import LARGEST

MOST_WHOLE = 1 << 40
SHOWN = 40
"""Largest number of letters of a value in a message."""


class Index(NamedTuple):
    """Place in a list of the JSON."""

    of: str


class Numbers(NamedTuple):
    """List of numbers; of any length for None."""

    length: int | None = None


class OneOf(NamedTuple):
    """One of some values."""

    values: tuple[object, ...]


class Each(NamedTuple):
    """List whose items follow a rule."""

    rule: "Rule"


class AllMembers(NamedTuple):
    """Object whose members follow a rule, whatever their names."""

    rule: "Rule"


class Members(NamedTuple):
    """Object with members that it must have, and others that it may have."""

    needed: dict[str, "Rule"]
    others: dict[str, "Rule"]


Rule = Index | Numbers | OneOf | Each | AllMembers | Members | type
"""A type is str, int (a whole number of 0 or more) or object (anything)."""

WHOLE = OneOf((5121, 5123, 5125))
NUMBER = OneOf((5120, 5121, 5122, 5123, 5125, 5126))
SHAPES = OneOf(("SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"))
INDICES = Members({"bufferView": Index("bufferViews"), "componentType": WHOLE}, {"byteOffset": int})
VALUES = Members({"bufferView": Index("bufferViews")}, {"byteOffset": int})
SPARSE = Members({"count": int, "indices": INDICES, "values": VALUES}, {})
PRIMITIVE = Members(
    {"attributes": AllMembers(Index("accessors"))},
    {"indices": Index("accessors"), "mode": OneOf(tuple(range(7))), "targets": Each(AllMembers(Index("accessors")))},
)
NODE = {
    "mesh": Index("meshes"),
    "skin": Index("skins"),
    "children": Each(Index("nodes")),
    "matrix": Numbers(16),
    "translation": Numbers(3),
    "rotation": Numbers(4),
    "scale": Numbers(3),
    "weights": Numbers(),
}
SAMPLER = Members(
    {"input": Index("accessors"), "output": Index("accessors")},
    {"interpolation": OneOf(("LINEAR", "STEP", "CUBICSPLINE"))},
)
CHANNEL = Members({"sampler": int, "target": Members({}, {"node": Index("nodes"), "path": str})}, {})
LISTS: dict[str, Rule] = {
    "accessors": Members(
        {"componentType": NUMBER, "type": SHAPES, "count": int},
        {"bufferView": Index("bufferViews"), "byteOffset": int, "sparse": SPARSE},
    ),
    "animations": Members({"samplers": Each(SAMPLER), "channels": Each(CHANNEL)}, {}),
    "buffers": Members({}, {"uri": str}),
    "bufferViews": Members({"buffer": Index("buffers")}, {"byteOffset": int, "byteStride": int}),
    "meshes": Members({"primitives": Each(PRIMITIVE)}, {"weights": Numbers()}),
    "nodes": Members({}, NODE),
    "scenes": Members({}, {"nodes": Each(Index("nodes"))}),
    "skins": Members({"joints": Each(Index("nodes"))}, {"inverseBindMatrices": Index("accessors")}),
}
"""Rule of the items of each list of the JSON."""
ROOT = Members(
    {"asset": Members({"version": object}, {})},
    {"scene": Index("scenes"), "extensionsRequired": Each(str), **{name: Each(rule) for name, rule in LISTS.items()}},
)


def check(json: Any, path: Path) -> None:
    """Check the JSON of a file; leave out members that are null, in place.

    Raises BadInput, with the place in the JSON, for the first value that is not right.
    """
    Checker(json, path).check(json, ROOT, "")


class Checker:
    """Check of the JSON of a file.

    counts  lengths of its lists, by name
    """

    def __init__(self, json: Any, path: Path) -> None:
        self.path = path
        lists = json if isinstance(json, dict) else {}
        self.counts = {name: len(lists[name]) for name in LISTS if isinstance(lists.get(name), list)}

    def check(self, value: Any, rule: Rule, place: str) -> None:
        """Check a value, and all in it."""
        match rule:
            case Index(name):
                count = self.counts.get(name, 0)
                self.demand(is_whole(value) and value < count, value, place, f"one of the {count} {name}, from 0")
            case Numbers(length):
                is_list = isinstance(value, list) and length in (None, len(value)) and all(map(is_number, value))
                self.demand(is_list, value, place, f"{'' if length is None else f'{length} '}numbers")
            case OneOf(values):
                is_known = isinstance(value, str | int) and value in values
                self.demand(is_known, value, place, f"one of {', '.join(map(str, values))}")
            case Each(inner):
                self.demand(isinstance(value, list), value, place, "a list")
                for number, item in enumerate(value):
                    self.check(item, inner, f"{place}[{number}]")
            case AllMembers(inner):
                self.demand(isinstance(value, dict), value, place, "an object")
                for name, item in value.items():
                    self.check(item, inner, f"{place}.{name[:SHOWN]}")
            case Members(needed, others):
                self.demand(isinstance(value, dict), value, place, "an object")
                for name, inner in (needed | others).items():
                    within = f"{place}.{name}".removeprefix(".")
                    if value.get(name) is not None:
                        self.check(value[name], inner, within)
                    elif name in needed:
                        raise BadInput("the value is missing", where=f"{self.path}, {place or 'JSON'}", right=name)
                    else:
                        value.pop(name, None)
            case kind:
                is_kind = is_whole(value) if kind is int else isinstance(value, kind)
                self.demand(is_kind, value, place, "a whole number" if kind is int else "a text")

    def demand(self, is_right: bool, value: Any, place: str, right: str) -> None:
        """Raise BadInput for a value that is not right."""
        if not is_right:
            raise BadInput(f"the value is {value!r:.{SHOWN}}", where=f"{self.path}, {place or 'JSON'}", right=right)


def is_whole(value: Any) -> bool:
    """Return whether a value is a whole number from 0 to MOST_WHOLE."""
    return type(value) is int and 0 <= value <= MOST_WHOLE


def is_number(value: Any) -> bool:
    """Return whether a value is a number of a usable size."""
    return type(value) in (int, float) and abs(value) <= LARGEST
