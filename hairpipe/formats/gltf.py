"""Meshes, bodies and motion of glTF 2.0 files (.gltf, .glb): nodes, skins, morph targets and their animations.

We read glTF ourselves: of the libraries that are kept up, `pygltflib` leaves accessors as bytes, and `trimesh` reads
neither skins nor animations. Source: glTF 2.0 Specification, Khronos Group 2021, 5: Properties Reference.

Readers of a checked JSON need no checks of their own: its indices exist, and its numbers are finite. Members that are
null are left out, and all that are not listed here are ignored.
"""

import base64
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at
from hairpipe.formats.polygons import Polygons, join_polygons, warn_of_unused
from hairpipe.formats.rigging import NOBODY, JointMotion, Key, Part, join_parts, jointed, rigid, unique_names
from hairpipe.formats.text import LARGEST
from hairpipe.plain_file import checked_size
from hairpipe.values import Body, Mesh, Skeleton

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


def check_json(json: Any, path: Path) -> None:
    """Check the JSON of a file, and leave out members that are null, in place.

    Raises BadInput, with the place in the JSON, for the first value that is not right.
    """
    lists = json if isinstance(json, dict) else {}
    counts = {name: len(lists[name]) for name in LISTS if isinstance(lists.get(name), list)}

    def demand(is_right: bool, value: Any, place: str, right: str) -> None:
        if not is_right:
            raise BadInput(f"the value is {value!r:.{SHOWN}}", where=f"{path}, {place or 'JSON'}", right=right)

    def check(value: Any, rule: Rule, place: str = "") -> None:
        match rule:
            case str(name):
                count = counts.get(name, 0)
                demand(_is_whole(value) and value < count, value, place, f"one of the {count} {name}, from 0")
            case Numbers(length):
                is_list = isinstance(value, list) and length in (None, len(value))
                is_list = is_list and all(type(n) in (int, float) and abs(n) <= LARGEST for n in value)
                demand(is_list, value, place, f"{'' if length is None else f'{length} '}numbers")
            case tuple(values):
                is_known = isinstance(value, str | int) and value in values
                demand(is_known, value, place, f"one of {', '.join(map(str, values))}")
            case [inner]:
                demand(isinstance(value, list), value, place, "a list")
                for number, item in enumerate(value):
                    check(item, inner, f"{place}[{number}]")
            case {"*": inner}:
                demand(isinstance(value, dict), value, place, "an object")
                for name, item in value.items():
                    check(item, inner, f"{place}.{name[:SHOWN]}")
            case dict(members):
                demand(isinstance(value, dict), value, place, "an object")
                for marked, inner in members.items():
                    name = marked.removesuffix("!")
                    if value.get(name) is not None:
                        check(value[name], inner, f"{place}.{name}".removeprefix("."))
                    elif name != marked:
                        raise BadInput("the value is missing", where=f"{path}, {place or 'JSON'}", right=name)
                    else:
                        value.pop(name, None)
            case kind:
                is_kind = _is_whole(value) if kind is int else isinstance(value, kind)
                demand(is_kind, value, place, "a whole number" if kind is int else "a text")

    check(json, ROOT)


def _is_whole(value: Any) -> bool:
    return type(value) is int and 0 <= value <= MOST_WHOLE


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
    """Return the files of a glTF file by relative paths; one alone, and of another format, has none."""
    is_gltf = path.suffix.lower() in SUFFIXES and path.is_file()
    return named(path, Document(path).files()) if is_gltf else {"": path}


def named(path: Path, files: list[Path]) -> dict[str, Path]:
    """Return files by their paths relative to the first one; one alone has none."""
    return {os.path.relpath(file, path.parent): file for file in files} if len(files) > 1 else {"": path}


def _refuse_constant(name: str) -> None:
    raise ValueError(name)  # NaN and Infinity, which JSON does not have


class Document:
    """The JSON of a file, and its binary data; BadInput for another version, or extensions that change meshes."""

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
        check_json(self.json, path)
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
        """Return the elements of an accessor, (n,) or (n, columns), float64 where they are fractions, else int64."""
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


WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}
REST = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}


class Track(NamedTuple):
    """Keys of one property of a node.

    times   ascending [s], (k,)
    values  (k, c); of a cubic (k, 3, c): tangent before, value, tangent after
    kind    LINEAR, STEP or CUBICSPLINE
    """

    times: np.ndarray
    values: np.ndarray
    kind: str

    def at(self, time: float, turns: bool) -> np.ndarray:
        """Return the value at a time, (c,); rotations are quaternions (x, y, z, w) of length 1."""
        times = self.times
        held = self.values[:, 1] if self.kind == "CUBICSPLINE" else self.values
        k = int(np.searchsorted(times, time, side="right")) - 1
        if k < 0 or k >= len(times) - 1:
            return unit(held[0 if k < 0 else -1], turns)
        span = times[k + 1] - times[k]
        share = (time - times[k]) / span
        if self.kind == "STEP" or share == 0.0:
            return unit(held[k], turns)
        if self.kind == "CUBICSPLINE":
            square = share * share
            cube = square * share
            weights = 2 * cube - 3 * square + 1, span * (cube - 2 * square + share), 3 * square - 2 * cube
            _, first, leaving = self.values[k]
            arriving, second, _ = self.values[k + 1]
            sums = weights[0] * first + weights[1] * leaving + weights[2] * second + span * (cube - square) * arriving
            return unit(sums, turns)
        return slerp(held[k], held[k + 1], share) if turns else (1.0 - share) * held[k] + share * held[k + 1]


def unit(values: np.ndarray, turns: bool) -> np.ndarray:
    return values / max(float(np.linalg.norm(values)), 1e-30) if turns else values


def slerp(first: np.ndarray, second: np.ndarray, share: float) -> np.ndarray:
    """Return the quaternion at a share of the shorter great arc between two."""
    first, second = unit(first, True), unit(second, True)
    cosine = float(first @ second)
    second, cosine = (second, cosine) if cosine >= 0.0 else (-second, -cosine)
    if cosine > 1.0 - 1e-9:
        return unit((1.0 - share) * first + share * second, True)
    angle = np.arccos(cosine)
    return (np.sin((1.0 - share) * angle) * first + np.sin(share * angle) * second) / np.sin(angle)


def find_take(clips: Sequence[Mapping[str, Any]]) -> list[int]:
    """Return the animations that play with the first, which move nothing that it moves: one for each object."""
    moved = set[tuple[Any, Any]]()
    found = list[int]()
    for number, clip in enumerate(clips):
        targets = [channel["target"] for channel in clip["channels"]]
        own = {(target.get("node"), target.get("path")) for target in targets}
        if moved.isdisjoint(own):
            found.append(number)
            moved |= own
    return found


class Animation:
    """The nodes of the scene of a file, and its animations of one take; none if nothing `moves`.

    tracks   by node and property
    parents  of all nodes, -1 at roots
    order    nodes of the scene, parents first
    """

    def __init__(self, document: Document, clip: str | None, moves: bool = True) -> None:
        self.document = document
        self.nodes = document.get("nodes")
        self.parents = np.full(len(self.nodes), -1)
        self.order = self._walk()
        self.tracks = self._read_tracks(clip) if moves else {}

    def _walk(self) -> list[int]:
        document = self.document
        scenes = document.get("scenes")
        children = {child for node in self.nodes for child in node.get("children", ())}
        roots = [node for node in range(len(self.nodes)) if node not in children]
        if scenes:
            roots = scenes[document.json.get("scene", 0)].get("nodes", [])
        order = dict[int, None]()
        pending = list(reversed(roots))
        while pending:
            node = pending.pop()
            if node in order:
                where = f"{document.path}, nodes[{node}]"
                raise BadInput("its nodes are not a tree", where=where, right="each node below one other, once")
            order[node] = None
            below = self.nodes[node].get("children", ())
            self.parents[list(below)] = node
            pending += reversed(below)
        return list(order)

    def _read_tracks(self, clip: str | None) -> dict[tuple[int, str], Track]:
        document = self.document
        clips = document.get("animations")
        names = [str(animation.get("name", index)) for index, animation in enumerate(clips)]
        chosen = [given for given, name in zip(clips, names, strict=True) if fnmatchcase(name, clip or name)]
        if clip is not None and not chosen:
            right = f"one of {', '.join(names[:12])}" if names else "no clip: the file has no animation"
            raise BadInput(f"there is no animation {clip!r}", where=document.path, right=right)
        if not clips:
            return {}
        if clip is None:
            numbers = find_take(clips)
            chosen = [clips[number] for number in numbers]
            if len(numbers) < len(clips):
                read = ", ".join(names[number] for number in numbers[:12])
                message = f"{document.path} has the animations {', '.join(names[:12])}: {read} is read"
                warnings.warn(f"{message}; `clip` selects another", stacklevel=2)
        found = {}
        for samplers, channel in ((c["samplers"], channel) for c in chosen for channel in c["channels"]):
            node, what = (channel["target"].get(name) for name in ("node", "path"))
            if node is None or what not in (*WIDTHS, "weights"):
                warnings.warn(f"{document.path}: a channel for {what} is not read", stacklevel=2)
                continue
            if channel["sampler"] >= len(samplers):
                where = f"{document.path}, animation of node {node}"
                raise BadInput(f"there is no sampler {channel['sampler']}", where=where, right=f"below {len(samplers)}")
            found[node, what] = self._read_track(samplers[channel["sampler"]], what)
        return found

    def _read_track(self, sampler: dict[str, Any], what: str) -> Track:
        times = self.document.numbers(sampler["input"], 1).astype(float)
        values = self.document.numbers(sampler["output"], WIDTHS.get(what, 1)).astype(float)
        kind = sampler.get("interpolation", "LINEAR")
        rows = (len(times), 3) if kind == "CUBICSPLINE" else (len(times),)
        where = f"{self.document.path}, accessor {sampler['output']}"
        is_ascending = len(times) > 0 and (np.diff(times) > 0.0).all()
        if not is_ascending or len(values) % np.prod(rows) or (what in WIDTHS and len(values) != np.prod(rows)):
            right = f"{'' if what in WIDTHS else 'a multiple of '}{np.prod(rows)} values, for ascending times"
            raise BadInput(f"{len(values)} values do not fit the times", where=where, right=right)
        return Track(times, values.reshape(*rows, -1), kind)

    @property
    def span(self) -> tuple[float, float] | None:
        """First and last time of all keys [s]; None without an animation."""
        ends = [(track.times[0], track.times[-1]) for track in self.tracks.values()]
        return (float(min(a for a, _ in ends)), float(max(b for _, b in ends))) if ends else None

    def transforms(self, time: float | None) -> np.ndarray:
        """Return the node-to-world matrices at a time [s], or at rest for None, column vectors, (N, 4, 4)."""
        world = np.tile(np.eye(4), (len(self.nodes), 1, 1))
        for node in self.order:
            parent = self.parents[node]
            local = self._local(node, time)
            world[node] = world[parent] @ local if parent >= 0 else local
        if not np.isfinite(world).all():
            where = f"{self.document.path}, nodes[{int(np.argmin(np.isfinite(world).all(axis=(1, 2))))}]"
            raise BadInput("the transform is not finite", where=where, right="smaller scales and translations")
        return world

    def _local(self, node: int, time: float | None) -> np.ndarray:
        given = self.nodes[node]
        if "matrix" in given:
            return np.array(given["matrix"], float).reshape(4, 4).T
        parts = {}
        for what, rest in REST.items():
            track = self.tracks.get((node, what))
            parts[what] = np.array(given.get(what, rest), float)
            if track is not None and time is not None:
                parts[what] = track.at(time, what == "rotation")
        x, y, z, w = unit(parts["rotation"], True)
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        )
        local = np.eye(4)
        local[:3, :3] = turn * parts["scale"]
        local[:3, 3] = parts["translation"]
        return local

    def weights(self, node: int, count: int, time: float | None) -> np.ndarray:
        """Return the weights of the morph targets of a node at a time, or at rest, (count,)."""
        track = self.tracks.get((node, "weights"))
        if track is not None and time is not None:
            values = track.at(time, False)
        else:
            given = self.nodes[node].get("weights")
            mesh = self.document.get("meshes")[self.nodes[node]["mesh"]]
            values = np.array(given if given is not None else mesh.get("weights", [0.0] * count), float)
        if len(values) != count:
            where = f"{self.document.path}, node {node}"
            raise BadInput(f"there are {len(values)} weights", where=where, right=f"{count}: one for each morph target")
        return values


KNOWN = ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0")
MOST_FRAMES = 1_000_000
"""Largest number of frames of an animation."""
TRIANGLES = 4
"""Mode of primitives: others are strips, fans, lines and points."""


class Piece(NamedTuple):
    """A mesh of a node, with welded vertices: formats for graphics cards have several where normals differ.

    points   at rest, in the space of the mesh [m], (n, 3) float64
    targets  displacements of the morph targets [m], (t, n, 3) float64
    skin     index of the skin; None without one, or without joints of vertices
    joints   nodes that move a vertex, (n, k) int64; weights  (n, k) float64, rows of sum 1
    maps     painted vertex values by name, (n,) float64
    """

    node: int
    points: np.ndarray
    targets: np.ndarray
    triangles: np.ndarray
    uv: np.ndarray | None
    skin: int | None
    joints: np.ndarray
    weights: np.ndarray
    maps: dict[str, np.ndarray]


class SkinnedPieces:
    """Samples of the meshes of a file, one a frame of the shot, see `animated_meshes.Samples`.

    Between keys rotations turn along arcs, which a cubic between sparse keys would not follow.
    """

    def __init__(self, path: Path, group: str | None, clip: str | None, fps: float, moves: bool = True) -> None:
        self.path, self.rate = path, fps
        self.document = Document(path)
        self.files = self.document.files()
        self.animation = Animation(self.document, clip, moves)
        self.pieces = [piece for node in self.animation.order for piece in self._pieces(node, group)]
        if not self.pieces:
            right = "a node with a mesh of triangles"
            raise BadInput(f"no mesh{'' if group is None else f' named {group}'}", where=path, right=right)
        self.skins = {p.skin: self._bind(p.skin) for p in self.pieces if p.skin is not None}
        first, last = self.animation.span or (0.0, 0.0)
        if not 0.0 <= (last - first) * fps <= MOST_FRAMES:
            right = f"at most {MOST_FRAMES:,} frames"
            raise BadInput(f"the animation takes {last - first:g} s", where=path, right=right)
        whole = np.arange(np.ceil(first * fps), np.floor(last * fps) + 1.0)
        codes = np.sort([first * fps, *whole, last * fps])
        self.codes = codes[np.insert(np.diff(codes) > 1e-6, 0, True)]
        self.own = [False] * len(self.pieces)

    def shape(self, sample: int) -> Polygons:
        pairs = zip(self.sample(sample), self.pieces, strict=True)
        meshes = [Mesh(points, piece.triangles, uv=piece.uv) for (points, _), piece in pairs]
        return join_polygons([Polygons(mesh, np.arange(len(mesh.triangles))) for mesh in meshes])

    def sample(self, sample: int) -> list[Points]:
        return [(points, None) for points in self.at(float(self.codes[sample] / self.rate))]

    def at(self, time: float | None) -> list[np.ndarray]:
        """Return the points of the meshes at a time [s], or at rest for None [m], (n, 3) each."""
        world = self.animation.transforms(time)
        found = [self._deformed(piece, world, time) for piece in self.pieces]
        if not all(np.isfinite(points).all() for points in found):
            raise BadInput("points are not finite", where=self.path, right="smaller scales, weights and translations")
        return found

    def _deformed(self, piece: Piece, world: np.ndarray, time: float | None) -> np.ndarray:
        points = piece.points
        if len(piece.targets):
            weights = self.animation.weights(piece.node, len(piece.targets), time)
            points = points + np.einsum("t,tnx->nx", weights, piece.targets)
        if piece.skin is None:
            return points @ world[piece.node, :3, :3].T + world[piece.node, :3, 3]
        matrices = world[:, :3].copy()
        nodes, bind = self.skins[piece.skin]
        matrices[nodes] = (world[nodes] @ bind)[:, :3]
        moved = np.zeros_like(points)
        for k in range(piece.joints.shape[1]):
            m = matrices[piece.joints[:, k]]
            moved += piece.weights[:, k, None] * (np.einsum("nij,nj->ni", m[:, :, :3], points) + m[:, :, 3])
        return moved

    def _bind(self, skin: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the joints of a skin, nodes (j,), and their inverse bind matrices, (j, 4, 4)."""
        given = self.document.get("skins")[skin]
        nodes = np.array(given["joints"], np.int64)
        where = f"{self.path}, skin {skin}"
        if lost := set(given["joints"]).difference(self.animation.order):
            raise BadInput(f"the joint {min(lost)} is not in the scene", where=where, right="a node of the scene")
        if "inverseBindMatrices" not in given:
            return nodes, np.tile(np.eye(4), (len(nodes), 1, 1))
        found = self.document.numbers(given["inverseBindMatrices"], 16).reshape(-1, 4, 4)
        if len(found) < len(nodes):
            raise BadInput(f"there are {len(found)} inverse bind matrices", where=where, right=f"{len(nodes)}")
        return nodes, np.swapaxes(found, 1, 2)[: len(nodes)]

    def _pieces(self, node: int, group: str | None) -> list[Piece]:
        given = self.document.get("nodes")[node]
        if "mesh" not in given or not self._fits(node, group):
            return []
        mesh = self.document.get("meshes")[given["mesh"]]
        name = f"{self.path}, mesh {mesh.get('name', given['mesh'])}"
        parts = [p for p in mesh["primitives"] if p.get("mode", TRIANGLES) == TRIANGLES]
        if len(parts) < len(mesh["primitives"]):
            warnings.warn(f"{name} has lines, points, strips or fans, which are not read", stacklevel=2)
        counts = sorted({len(p.get("targets", ())) for p in parts})
        if len(counts) > 1:
            right = f"{counts[-1]} for each, or none"
            raise BadInput(f"a primitive has {counts[0]} morph targets", where=name, right=right)
        return [weld(self._primitive(part, node, name)) for part in parts]

    def _fits(self, node: int, group: str | None) -> bool:
        """Return whether the name of a node, or of one above it, is that of a group or fits its pattern."""
        while node >= 0:
            name = str(self.document.get("nodes")[node].get("name", ""))
            if group is None or name == group or fnmatchcase(name, group):
                return True
            node = self.animation.parents[node]
        return False

    def _primitive(self, part: dict[str, Any], node: int, where: str) -> Piece:
        given = part.get("attributes", {})
        if "POSITION" not in given:
            raise BadInput("a primitive has no positions", where=where, right="the attribute POSITION")
        points = self.document.numbers(given["POSITION"], 3).astype(float)
        n = len(points)
        if not n:
            raise BadInput("a primitive has no positions", where=where, right="3 or more")

        def numbers(index: int, columns: int) -> np.ndarray:
            found = self.document.numbers(index, columns)
            if len(found) != n:
                at = f"{self.path}, accessor {index}"
                raise BadInput(f"{len(found)} elements for {n} vertices", where=at, right="as many as positions")
            return found

        corners = self.document.numbers(part["indices"], 1).astype(np.int64) if "indices" in part else np.arange(n)
        if len(corners) % 3 or (len(corners) and not 0 <= corners.min() <= corners.max() < n):
            raise BadInput("indices are not those of triangles", where=where, right=f"triples of 0 to {n - 1}")
        targets = [numbers(t["POSITION"], 3) if "POSITION" in t else np.zeros((n, 3)) for t in part.get("targets", ())]
        sets = [k for k in range(16) if f"JOINTS_{k}" in given and f"WEIGHTS_{k}" in given]
        indices, shares = ([numbers(given[f"{name}_{k}"], 4) for k in sets] for name in ("JOINTS", "WEIGHTS"))
        skin = self.document.get("nodes")[node].get("skin") if sets else None
        joints, weights = self._influences(indices, shares, skin, node, n, where)
        triangles = corners.reshape(-1, 3)
        uv = numbers(given["TEXCOORD_0"], 2)[triangles] * (1, -1) + (0, 1) if "TEXCOORD_0" in given else None
        scalars = self.document.get("accessors")
        painted = [k for k, index in given.items() if k.startswith("_") and scalars[index].get("type") == "SCALAR"]
        maps = {name[1:].lower(): numbers(given[name], 1).astype(float).clip(0.0, 1.0) for name in painted}
        known = [name for name in given if name.startswith(("JOINTS_", "WEIGHTS_"))]
        warn_of_unused(where, given.keys() - {*KNOWN, *painted, *known})
        stacked = np.array(targets, float).reshape(-1, n, 3)
        texture = None if uv is None else uv.astype(np.float32)
        return Piece(node, points, stacked, triangles, texture, skin, joints, weights, maps)

    def _influences(
        self, indices: list[np.ndarray], shares: list[np.ndarray], skin: int | None, node: int, n: int, where: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes that move vertices, (n, k), and their weights, (n, k), from those of each set of four."""
        if skin is None:
            return np.full((n, 1), node), np.ones((n, 1))
        nodes = np.array(self.document.get("skins")[skin]["joints"], np.int64)
        joints = np.concatenate(indices, axis=1).astype(int)
        weights = np.concatenate(shares, axis=1).astype(float)
        if joints.min() < 0 or joints.max() >= len(nodes) or weights.min() < 0.0:
            right = f"joints 0 to {len(nodes) - 1}, weights of 0 or more"
            raise BadInput("a vertex has an invalid joint or weight", where=where, right=right)
        weights[weights.sum(axis=1) == 0.0, 0] = 1.0
        return nodes[joints], weights / weights.sum(axis=1, keepdims=True)


def weld(piece: Piece) -> Piece:
    """Return a mesh whose equal vertices, in position, morph targets, skin and maps, are one; pure."""
    n = len(piece.points)
    columns = [piece.points, piece.targets.swapaxes(0, 1).reshape(n, -1), piece.joints, piece.weights]
    columns += [values[:, None] for values in piece.maps.values()]
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1) + 0.0)
    _, first, place = np.unique(
        rows.view([("", rows.dtype)] * rows.shape[1])[:, 0], return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    kept = first[order]
    triangles = np.argsort(order)[place.reshape(-1)][piece.triangles]
    real = (triangles != triangles[:, (1, 2, 0)]).all(axis=1)
    return piece._replace(
        points=piece.points[kept],
        targets=piece.targets[:, kept],
        triangles=np.ascontiguousarray(triangles[real], np.int32),
        uv=None if piece.uv is None else piece.uv[real],
        joints=piece.joints[kept],
        weights=piece.weights[kept],
        maps={name: values[kept] for name, values in piece.maps.items()},
    )


def read_moving(path: Path, group: str | None, clip: str | None, instant: Instant) -> Polygons:
    """Read the meshes of a clip at an instant."""
    return read_at(recall(SkinnedPieces, path, group, clip, instant.fps), instant)


ALIKE = 1e-5
"""Largest difference of motions of a joint from the bound mesh to rest, relative or [m]: positions are float32."""


def find_joints(pieces: SkinnedPieces) -> tuple[list[int], np.ndarray, Skeleton]:
    """Find the nodes that move the meshes, a parent before its children, and their transforms [m], (J, 4, 4).

    These are the nodes of skins, and of meshes without one. Raises BadInput where one has no inverse at rest.
    """
    animation = pieces.animation
    used = {int(node) for piece in pieces.pieces for node in np.unique(piece.joints)}
    nodes = [node for node in animation.order if node in used]
    given = [str(animation.nodes[node].get("name") or f"node{node}") for node in nodes]
    names = [n if given.count(n) == 1 else f"{n}#{node}" for n, node in zip(given, nodes, strict=True)]
    above = animation.parents.tolist()
    parents = list[int]()
    for node in nodes:
        parent = above[node]
        while parent >= 0 and parent not in used:
            parent = above[parent]
        parents.append(nodes.index(parent) if parent >= 0 else -1)
    world = animation.transforms(None)[nodes]
    volumes = np.abs(np.linalg.det(world[:, :3, :3]))
    if volumes.min() < 1e-30:
        where = f"{pieces.path}, joint {names[int(np.argmin(volumes))]}"
        raise BadInput("the transform at rest cannot be inverted", where=where, right="a scale that is not 0")
    return nodes, world, jointed(names, np.array(parents, np.int32), rigid(world))


def read_body(path: Path, group: str | None = None) -> Body:
    """Read the meshes of a file at rest as one body, with the joints of their skins; without skins it has no joints.

    group  name of a node, or a pattern of names, to read with all below; None for all

    Raises BadInput where the file cannot be used; the message names the mesh or the accessor.
    """
    pieces = SkinnedPieces(path, group, None, 24.0, moves=False)
    nodes, _, skeleton = find_joints(pieces) if pieces.skins else ([], np.zeros((0, 4, 4)), NOBODY)
    places = np.zeros(len(pieces.animation.nodes), np.int32)
    places[nodes] = np.arange(len(nodes))
    binds = bind_pieces(pieces)
    names = name_weights(pieces)
    parts = list[Part]()
    for points, piece, (matrix, _) in zip(pieces.at(None), pieces.pieces, binds, strict=True):
        mesh = Mesh(points, piece.triangles, uv=piece.uv)
        k = piece.joints.shape[1] if nodes else 0
        base = piece.points @ matrix[:3, :3].T + matrix[:3, 3]
        rows = [np.flatnonzero((target != 0.0).any(axis=1)) for target in piece.targets]
        targets = zip(names[piece.node], piece.targets, rows, strict=True)
        keys = [Key(name, 1.0, row, target[row] @ matrix[:3, :3].T) for name, target, row in targets]
        parts.append(Part(mesh, piece.maps, places[piece.joints[:, :k]], piece.weights[:, :k], base, keys))
    turns = join_turns(nodes, skeleton.names, [turns for _, turns in binds], path)
    return join_parts(parts, skeleton, turns, weights_of(pieces, names, None))


def bind_pieces(pieces: SkinnedPieces) -> list[tuple[np.ndarray, dict[int, np.ndarray]]]:
    """Return the matrix of every mesh to its place in the world, (4, 4), and motions of its nodes from there to rest.

    The place is the one at rest, where nodes agree about it. A mesh with a node of another mesh has the place from
    which that node moves both alike.
    """
    world = pieces.animation.transforms(None)
    moved = list[dict[int, np.ndarray]]()
    for piece in pieces.pieces:
        own = (np.array([piece.node]), np.eye(4)[None])
        nodes, unbind = own if piece.skin is None else pieces.skins[piece.skin]
        used = np.isin(nodes, piece.joints)
        moved.append(dict(zip(nodes[used].tolist(), world[nodes[used]] @ unbind[used], strict=True)))
    found = dict[int, tuple[np.ndarray, dict[int, np.ndarray]]]()
    turns = dict[int, np.ndarray]()
    while len(found) < len(moved):
        waiting = [n for n in range(len(moved)) if n not in found]
        number = next((n for n in waiting if not turns.keys().isdisjoint(moved[n])), waiting[0])
        regular = {node: motion for node, motion in moved[number].items() if abs(np.linalg.det(motion[:3, :3])) > 1e-30}
        first = next(iter(moved[number]))
        place = next(
            (np.linalg.inv(turns[node]) @ motion for node, motion in regular.items() if node in turns),
            regular.get(first, np.eye(4)),
        )
        unplace = np.linalg.inv(place)
        found[number] = place, {node: motion @ unplace for node, motion in moved[number].items()}
        turns = {node: found[number][1][node] for node in regular} | turns
    return [found[n] for n in range(len(moved))]


def join_turns(nodes: list[int], names: Sequence[str], binds: list[dict[int, np.ndarray]], path: Path) -> np.ndarray:
    """Return the motion of each joint from the bound mesh to rest, (J, 4, 4); warns where meshes disagree about one."""
    turns = np.tile(np.eye(4), (len(nodes), 1, 1))
    for place, node in enumerate(nodes):
        found = [bind[node] for bind in binds if node in bind]
        turns[place] = found[0]
        if any(np.abs(other - found[0]).max() > ALIKE for other in found):
            message = f"{path}: skins bind the joint {names[place]} in several ways"
            warnings.warn(f"{message}: poses follow the first (load_mesh_cache reads all points)", stacklevel=2)
    return turns


def name_weights(pieces: SkinnedPieces) -> dict[int, list[str]]:
    """Return the names of the morph targets of every node; equal ones with their number or their node: smile#2."""
    given = dict[int, list[str]]()
    for piece in pieces.pieces:
        extras = pieces.document.get("meshes")[pieces.animation.nodes[piece.node]["mesh"]].get("extras")
        named = extras.get("targetNames") if isinstance(extras, dict) else None
        named = named if isinstance(named, list) else []
        count = len(piece.targets)
        names = [str(named[k]) if k < len(named) else f"target{k}" for k in range(count)]
        given[piece.node] = unique_names(names, range(count))
    owners = [node for node, names in given.items() for _ in names]
    unique = iter(unique_names([name for names in given.values() for name in names], owners))
    return {node: [next(unique) for _ in names] for node, names in given.items()}


def weights_of(pieces: SkinnedPieces, named: dict[int, list[str]], time: float | None) -> dict[str, float]:
    """Return the weights of the morph targets, named by node, at a time [s], or at rest, by name."""
    return {
        name: float(weight)
        for node, names in named.items()
        for name, weight in zip(names, pieces.animation.weights(node, len(names), time), strict=True)
    }


def read_joints(path: Path, group: str | None, clip: str | None, fps: float) -> JointMotion:
    """Read the joints and weights of a clip, with a sample at each frame of the shot."""
    pieces = SkinnedPieces(path, group, clip, fps)
    nodes, world, skeleton = find_joints(pieces)
    unbind = np.linalg.inv(world) @ skeleton.rest
    moved = [pieces.animation.transforms(float(code / fps))[nodes] @ unbind for code in pieces.codes]
    named = name_weights(pieces)
    weights = np.array([[*weights_of(pieces, named, float(code / fps)).values()] for code in pieces.codes])
    shapes = tuple(weights_of(pieces, named, None))
    return JointMotion(skeleton, np.array(moved), pieces.codes, fps, float(pieces.codes[0]), shapes, weights)
