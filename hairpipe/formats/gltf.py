"""Content of a glTF 2.0 file: its JSON and the numbers of its accessors, which are read from mapped files on demand.

We read glTF ourselves: of the libraries that are kept up, `pygltflib` leaves accessors as bytes, and `trimesh` reads
neither skins nor animations. Source: glTF 2.0 Specification, Khronos Group 2021, 5: Properties Reference.

Readers of a checked JSON need no checks of their own: its indices exist, and its numbers are finite. Members that are
null are left out, and all that are not listed here are ignored.
"""

import base64
import json
import os
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.text import LARGEST
from hairpipe.plain_file import checked_size

MOST_WHOLE = 1 << 40
SHOWN = 40
"""Largest number of letters of a value in a message."""


class Numbers(NamedTuple):
    """List of numbers; of any length for None."""

    length: int | None = None


Rule = Any
"""What a value of the JSON may be.

    "nodes"          an index of the list of this name
    [rule]           a list whose items follow a rule
    {"*": rule}      an object whose members follow a rule, whatever their names
    {"name!": rule}  an object that must have a member, or may, without the mark
    (a, b)           one of some values
    type             str, int (a whole number of 0 or more) or object (anything)
"""
VALUES = {"bufferView!": "bufferViews", "byteOffset": int}
INDICES = {**VALUES, "componentType!": (5121, 5123, 5125)}
ACCESSORS = {"*": "accessors"}
LISTS: dict[str, Rule] = {
    "accessors": {
        "componentType!": (5120, 5121, 5122, 5123, 5125, 5126),
        "type!": ("SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"),
        "count!": int,
        "bufferView": "bufferViews",
        "byteOffset": int,
        "sparse": {"count!": int, "indices!": INDICES, "values!": VALUES},
    },
    "animations": {
        "samplers!": [
            {"input!": "accessors", "output!": "accessors", "interpolation": ("LINEAR", "STEP", "CUBICSPLINE")}
        ],
        "channels!": [{"sampler!": int, "target!": {"node": "nodes", "path": str}}],
    },
    "buffers": {"uri": str},
    "bufferViews": {"buffer!": "buffers", "byteOffset": int, "byteStride": int},
    "meshes": {
        "primitives!": [
            {"attributes!": ACCESSORS, "indices": "accessors", "mode": tuple(range(7)), "targets": [ACCESSORS]}
        ],
        "weights": Numbers(),
    },
    "nodes": {
        "mesh": "meshes",
        "skin": "skins",
        "children": ["nodes"],
        "matrix": Numbers(16),
        "translation": Numbers(3),
        "rotation": Numbers(4),
        "scale": Numbers(3),
        "weights": Numbers(),
    },
    "scenes": {"nodes": ["nodes"]},
    "skins": {"joints!": ["nodes"], "inverseBindMatrices": "accessors"},
}
"""Rule of the items of each list of the JSON."""
ROOT = {
    "asset!": {"version!": object},
    "scene": "scenes",
    "extensionsRequired": [str],
    **{name: [rule] for name, rule in LISTS.items()},
}


class Checker:
    """Check of the JSON of a file, which leaves out members that are null, in place.

    counts  lengths of its lists, by name

    Raises BadInput, with the place in the JSON, for the first value that is not right.
    """

    def __init__(self, json: Any, path: Path) -> None:
        self.path = path
        lists = json if isinstance(json, dict) else {}
        self.counts = {name: len(lists[name]) for name in LISTS if isinstance(lists.get(name), list)}

    def check(self, value: Any, rule: Rule, place: str = "") -> None:
        """Check a value, and all in it."""
        match rule:
            case str(name):
                count = self.counts.get(name, 0)
                self.demand(_is_whole(value) and value < count, value, place, f"one of the {count} {name}, from 0")
            case Numbers(length):
                is_list = isinstance(value, list) and length in (None, len(value)) and all(map(_is_number, value))
                self.demand(is_list, value, place, f"{'' if length is None else f'{length} '}numbers")
            case tuple(values):
                is_known = isinstance(value, str | int) and value in values
                self.demand(is_known, value, place, f"one of {', '.join(map(str, values))}")
            case [inner]:
                self.demand(isinstance(value, list), value, place, "a list")
                for number, item in enumerate(value):
                    self.check(item, inner, f"{place}[{number}]")
            case {"*": inner}:
                self.demand(isinstance(value, dict), value, place, "an object")
                for name, item in value.items():
                    self.check(item, inner, f"{place}.{name[:SHOWN]}")
            case dict(members):
                self.demand(isinstance(value, dict), value, place, "an object")
                for marked, inner in members.items():
                    name = marked.removesuffix("!")
                    if value.get(name) is not None:
                        self.check(value[name], inner, f"{place}.{name}".removeprefix("."))
                    elif name != marked:
                        raise BadInput("the value is missing", where=f"{self.path}, {place or 'JSON'}", right=name)
                    else:
                        value.pop(name, None)
            case kind:
                is_kind = _is_whole(value) if kind is int else isinstance(value, kind)
                self.demand(is_kind, value, place, "a whole number" if kind is int else "a text")

    def demand(self, is_right: bool, value: Any, place: str, right: str) -> None:
        if not is_right:
            raise BadInput(f"the value is {value!r:.{SHOWN}}", where=f"{self.path}, {place or 'JSON'}", right=right)


def _is_whole(value: Any) -> bool:
    return type(value) is int and 0 <= value <= MOST_WHOLE


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) <= LARGEST


SUFFIXES = (".gltf", ".glb")
RIGHT = "a glTF 2.0 file, .gltf or .glb"
HEADER, JSON, BINARY = b"glTF", b"JSON", b"BIN\0"
MOST_JSON = 256 << 20
"""Largest size of the JSON [bytes]; the largest of characters is a few MB."""
MOST_ITEMS = 4_000_000
"""Largest number of items of the JSON: each takes about 100 bytes of memory."""
MOST_COUNT = 1 << 26
"""Largest number of elements of an accessor."""
KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
UNUSED = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_mesh_quantization")
"""Extensions that a file may require: of looks, and of accessors of integers, which are read anyway."""


def list_files(path: Path) -> dict[str, Path]:
    """Return the files that a glTF file consists of by relative paths; one alone, and of another format, has none.

    Raises BadInput where its JSON cannot be read.
    """
    is_gltf = path.suffix.lower() in SUFFIXES and path.is_file()
    return named(path, Document(path).files()) if is_gltf else {"": path}


def named(path: Path, files: list[Path]) -> dict[str, Path]:
    """Return files by their paths relative to the first one; one alone has none."""
    return {os.path.relpath(file, path.parent): file for file in files} if len(files) > 1 else {"": path}


def _refuse_constant(name: str) -> None:
    raise ValueError(name)  # NaN and Infinity, which JSON does not have


class Document:
    """The JSON of a file, and its binary data.

    Raises BadInput where the file is not glTF 2.0, or requires an extension that changes its meshes.
    """

    def __init__(self, path: Path) -> None:
        size = checked_size(path, RIGHT)
        self.path = path
        self.binary = np.zeros(0, np.uint8)
        data = np.memmap(path, np.uint8, "r")
        if bytes(data[:4]) == HEADER:
            data = self._chunk(data, 12, JSON)
            rest = 20 + len(data)
            if rest < size:
                self.binary = self._chunk(np.memmap(path, np.uint8, "r"), rest, BINARY)
        if len(data) > MOST_JSON:
            raise BadInput(f"its JSON has {len(data):,} bytes", where=path, right=f"at most {MOST_JSON:,}")
        text = bytes(data)
        items = sum(map(text.count, (b",", b"[", b"{")))
        if items > MOST_ITEMS:
            raise BadInput(f"its JSON has {items:,} items", where=path, right=f"at most {MOST_ITEMS:,}")
        try:
            self.json = json.loads(text, parse_constant=_refuse_constant)
        except (ValueError, RecursionError):
            raise BadInput("its JSON cannot be read", where=path, right=RIGHT) from None
        Checker(self.json, path).check(self.json, ROOT)
        version = str(self.json["asset"]["version"])
        if not version.startswith("2."):
            raise BadInput(f"the version of glTF is {version[:20]}", where=path, right="2.0")
        others = [name for name in self.get("extensionsRequired") if not name.startswith(UNUSED)]
        if others:
            right = "a file without it: no compression"
            raise BadInput(f"the file requires the extension {others[0]}, which is not read", where=path, right=right)
        self.buffers: dict[int, np.ndarray] = {}

    def _chunk(self, data: np.ndarray, begin: int, kind: bytes) -> np.ndarray:
        length = int.from_bytes(bytes(data[begin : begin + 4]), "little")
        if bytes(data[begin + 4 : begin + 8]) != kind or begin + 8 + length > len(data):
            what = f"there is no chunk {kind.decode().strip(chr(0))} at byte {begin}"
            raise BadInput(what, where=self.path, right=RIGHT)
        return data[begin + 8 : begin + 8 + length]

    def get(self, name: str) -> list[Any]:
        return self.json.get(name, [])

    def files(self) -> list[Path]:
        texts = [buffer.get("uri", "data:") for buffer in self.get("buffers")]
        return [self.path, *(self._file_of(text) for text in texts if not text.startswith("data:"))]

    def _file_of(self, text: str) -> Path:
        """Return the file of a reference; BadInput where it is not a regular file below the folder of this one."""
        right = f"a buffer in the folder of {self.path.name}"
        file = self.path.parent / unquote(text)
        folders = self.path.parent.resolve(), self.path.resolve().parent
        try:
            is_inside = any(file.resolve().is_relative_to(folder) for folder in folders)
        except (ValueError, RuntimeError):  # of a name that no file can have, and of links to each other
            raise BadInput(f"the file {text[:60]!r} cannot exist", where=self.path, right=right) from None
        if not is_inside:
            raise BadInput(f"the file {text[:60]!r} is outside of its folder", where=self.path, right=right)
        try:
            checked_size(file, right)
        except BadInput as fault:
            raise BadInput(f"the buffer {text[:60]!r}: {fault.what}", where=self.path, right=right) from None
        return file

    def buffer(self, index: int) -> np.ndarray:
        """Return the bytes of a buffer, mapped from its file."""
        if index not in self.buffers:
            text = self.get("buffers")[index].get("uri")
            if text is None:
                self.buffers[index] = self.binary
            elif text.startswith("data:"):
                try:
                    self.buffers[index] = np.frombuffer(base64.b64decode(text.partition(",")[2]), np.uint8)
                except ValueError:
                    raise BadInput(f"buffer {index} is not in base 64", where=self.path, right=RIGHT) from None
            else:
                self.buffers[index] = np.memmap(self._file_of(text), np.uint8, "r")
        return self.buffers[index]

    def numbers(self, index: int, columns: int) -> np.ndarray:
        """Return the elements of an accessor, (n,) or (n, columns), float64 where they are fractions, else integers.

        Raises BadInput where it is of another type, or beyond its buffer.
        """
        where = f"{self.path}, accessor {index}"
        accessor = self.get("accessors")[index]
        kind = np.dtype(KINDS[accessor["componentType"]])
        if COLUMNS.get(accessor["type"]) != columns:
            raise BadInput(f"is a {accessor['type']}", where=where, right=f"{columns} numbers each")
        count = accessor["count"]
        if count > MOST_COUNT:
            raise BadInput(f"has {count:,} elements", where=where, right=f"at most {MOST_COUNT:,}")
        values = self._view(accessor, kind, (count, columns), where)
        if sparse := accessor.get("sparse"):
            integers = np.dtype(KINDS[sparse["indices"]["componentType"]])
            rows = self._view(sparse["indices"], integers, (sparse["count"], 1), where)[:, 0]
            if len(rows) and rows.max() >= count:
                raise BadInput(f"replaces the element {rows.max()}", where=where, right=f"0 to {count - 1}")
            values = values.copy()
            values[rows] = self._view(sparse["values"], kind, (len(rows), columns), where)
        if accessor.get("normalized") and kind.kind in "iu":
            values = np.maximum(values / np.iinfo(kind).max, -1.0)
        values = values.astype(np.float64) if values.dtype.kind == "f" else values.astype(np.int64)
        if not (np.abs(values) <= LARGEST).all():
            raise BadInput("has numbers that are not usable", where=where, right=f"finite numbers up to {LARGEST:g}")
        return values[:, 0] if columns == 1 else values

    def _view(self, given: dict[str, Any], kind: np.dtype, shape: tuple[int, int], where: str) -> np.ndarray:
        """Return elements of a view of a buffer, zeros without a view; BadInput where the buffer is too short."""
        if "bufferView" not in given or not shape[0]:
            return np.zeros(shape, kind)
        view = self.get("bufferViews")[given["bufferView"]]
        begin = view.get("byteOffset", 0) + given.get("byteOffset", 0)
        stride = view.get("byteStride") or kind.itemsize * shape[1]
        data = self.buffer(view["buffer"])
        end = begin + stride * (shape[0] - 1) + kind.itemsize * shape[1]
        if end > len(data):
            raise BadInput(f"ends at byte {end:,} of a buffer of {len(data):,}", where=where, right="a whole buffer")
        return np.ndarray(shape, kind, np.ascontiguousarray(data), begin, (stride, kind.itemsize))
