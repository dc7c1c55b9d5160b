"""Documents of values for the browser: strands, meshes, particles, level sets, tables; those of a shot by name.

Arrays are compact text that a browser unpacks without a library: differences, byte planes, deflate, base64.

A page opened from a file may not fetch, but it may load scripts: every document is a script that calls `hairpipe.load`
with a name, a plain value and this text.
"""

import base64
import dataclasses
import json
import math
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe.app.api.graph_shot import GraphShot
from hairpipe.app.api.reports import Plan, Task
from hairpipe.app.api.shot import Record
from hairpipe.engine import File
from hairpipe.engine.store.digest import digest_bytes
from hairpipe.errors import BadInput
from hairpipe.geometry.isosurface import extract_surface
from hairpipe.values import Body, Cloud, Density, Groom, LevelSet, Mesh, Particles, PointValues, Strands, Table
from hairpipe.values.hair import HairState

EFFORT, QUICK, LARGE = 9, 1, 4_000_000
"""Levels of deflate, 1 to 9: the slowest saves a tenth of the bytes; the quick one is for arrays of so many bytes."""
STEPS = 16383  # bits of a quantised coordinate: 14 bits are 30 um in half a metre, less than the thickness of a hair

Packed = tuple[dict[str, Any], bytes]
"""Meta data for unpacking, and the bytes before base64."""


def quantised(points: np.ndarray) -> tuple[np.ndarray, dict[str, Any]]:
    """Return points (n, 3) as whole steps (n, 3) int64 of their box, and the box: `low` and `step` [m]. Pure.

    The error is at most half a step: 16383 of them span the longest side of the box.
    """
    if not len(points):
        return np.zeros((0, 3), np.int64), {"low": [0.0, 0.0, 0.0], "step": 1.0}
    low = points.min(axis=0)
    step = float((points - low).max()) / STEPS or 1.0
    return np.rint((points - low) / step).astype(np.int64), {"low": low.tolist(), "step": step}


def second_differences(values: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the first value of every strand, the first difference, then second ones: small if it is smooth."""
    lengths = np.diff(offsets)
    begins = offsets[:-1][lengths > 0]
    followers = offsets[:-1][lengths > 1] + 1
    first = np.diff(values, axis=0, prepend=0)
    second = np.diff(first, axis=0, prepend=0)
    second[begins], second[followers] = values[begins], first[followers]
    return second


def zigzag(values: np.ndarray) -> np.ndarray:
    """Return signed differences modulo 2^16 as (n, 3) uint16, small for small ones of either sign; pure."""
    wrapped = values.astype(np.int16)
    return ((wrapped << 1) ^ (wrapped >> 15)).view(np.uint16)


def pack(arrays: Mapping[str, np.ndarray], **meta: Any) -> Packed:
    """Pack arrays of uint8, uint16 or uint32, column by column and byte by byte, with plain values added; pure."""
    places, planes = [], []
    for name, array in arrays.items():
        flat = np.ascontiguousarray(array.T if array.ndim == 2 else array).ravel()
        size = flat.dtype.itemsize
        bytewise = flat.view(np.uint8).reshape(-1, size).T
        places.append({"name": name, "bytes": size, "shape": list(array.shape)})
        planes.append(bytewise.tobytes())
    joined = b"".join(planes)
    return {**meta, "arrays": places}, zlib.compress(joined, EFFORT if len(joined) < LARGE else QUICK)


def script(name: str, document: Any, packed: bytes = b"") -> str:
    """Write a document as a script; texts are escaped, so that they cannot end the script element."""
    return f'hairpipe.load({literal(name)},{literal(document)},"{base64.b64encode(packed).decode()}");\n'


def literal(value: Any) -> str:
    """Write a plain value as a literal for a script element; ValueError for NaN and infinity."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")


MOST_SAMPLES = 4_000_000
"""Largest number of samples of a drawn level set; a larger one is drawn from every second sample, or third."""

WIDTHS = 63  # steps of the width of hair, up to its widest


def strands_document(hair: Strands | Groom, most: int) -> Packed:
    """Describe strands: places to half a quantisation step, speed to 1/255 of the fastest, widths that vary; pure.

    most  maximum number of strands, chosen evenly from all; `total` is their number
    """
    count = len(hair.offsets) - 1
    shown, lengths, kept = thinned(hair.offsets, most)
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    places, box = quantised(hair.points[kept])
    arrays = {"points": zigzag(second_differences(places, offsets)), "lengths": lengths.astype(np.uint16)}
    if len(shown) < count:
        arrays["strands"] = shown.astype(np.uint32)
    if isinstance(hair, Groom) and hair.root_uv.any():
        arrays["uv"] = hair.root_uv[shown].astype(np.float32).view(np.uint32)
    meta: dict[str, Any] = {"total": count, "diameter": getattr(hair, "diameter", 0.0), **box}
    if isinstance(hair, Strands):
        meta["diameter"], widths = width_steps(hair, kept)
        if widths is not None:
            arrays["widths"] = widths
        speeds = np.linalg.norm(hair.velocities[kept].astype(float), axis=1)
        meta["fastest"] = fastest = float(speeds.max(initial=0.0))
        steps = np.rint(speeds * (255.0 / fastest if fastest else 0.0)).astype(np.int64)
        arrays["speeds"] = np.diff(steps, prepend=0).astype(np.uint8)
    return pack(arrays, **meta)


def width_steps(hair: Strands, kept: np.ndarray) -> tuple[float, np.ndarray | None]:
    """Return the largest width [m], and the widths of points in steps of it, (p,) uint8, if they vary; pure."""
    if hair.widths is None:
        return hair.diameter, None
    widest = float(hair.widths.max(initial=1e-9))
    return widest, np.rint(hair.widths[kept] * (WIDTHS / widest)).astype(np.uint8)


def thinned(offsets: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Choose strands evenly: indices, (s,), numbers of points, (s,), and indices of points, (p,), all int64; pure.

    most  maximum number of strands
    """
    count = len(offsets) - 1
    shown = np.linspace(0, max(count - 1, 0), min(most, count)).round().astype(np.int64)
    lengths = np.diff(offsets)[shown].astype(np.int64)
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]]) if count else np.zeros(0, np.int64)
    return shown, lengths, np.arange(lengths.sum()) + np.repeat(np.asarray(offsets)[shown] - starts, lengths)


def values_document(measured: PointValues, most: int) -> Packed:
    """Describe values at points of strands to 1/255 of their range, non-finite ones as the least; pure."""
    arrays = {}
    ranges = []
    kept = thinned(measured.offsets, most)[2]
    for place, values in enumerate(measured.values[:, kept].astype(float)):
        known = values[np.isfinite(values)]
        low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
        steps = np.nan_to_num((values - low) * (255.0 / (high - low or 1.0)), posinf=255.0).clip(0.0, 255.0)
        arrays[f"values{place}"] = np.diff(np.rint(steps).astype(np.int64), prepend=0).astype(np.uint8)
        ranges.append([low, high])
    return pack(arrays, names=list(measured.names), ranges=ranges)


def mesh_document(mesh: Mesh) -> Packed:
    """Describe the vertices of a mesh, and the name of its triangles; pure."""
    places, box = quantised(mesh.points)
    one = np.array([0, len(places)])
    return pack({"points": zigzag(second_differences(places, one))}, faces=faces_name(mesh), **box)


def faces_name(mesh: Mesh) -> str:
    """Name the triangles of a mesh by their content, so that frames of a body share them."""
    coordinates = b"" if mesh.uv is None else mesh.uv.tobytes()
    return digest_bytes("faces", np.ascontiguousarray(mesh.triangles).tobytes() + coordinates)


def faces_document(mesh: Mesh) -> Packed:
    """Describe the triangles of a mesh, and the texture coordinates of their corners if it has them; pure."""
    arrays = {"triangles": mesh.triangles.astype(np.uint32)}
    if mesh.uv is not None:
        arrays["uv"] = mesh.uv.astype(np.float32).reshape(-1, 2).view(np.uint32)
    return pack(arrays)


def maps_document(painted: Body | Groom) -> Packed:
    """Name the maps of a body or groom, and the groups of a groom; pure.

    Maps on the vertices of a body are described from 0 to 255.
    """
    kept = painted.maps if isinstance(painted, Body) else {}
    arrays = {name: np.rint(255.0 * values.clip(0.0, 1.0)).astype(np.uint8) for name, values in kept.items()}
    return pack(arrays, names=[*painted.maps, *getattr(painted, "group_names", ())])


def points_document(cloud: Cloud | Particles) -> Packed:
    """Describe particles, and the direction of hair at each; pure."""
    places, box = quantised(cloud.points)
    directions = np.rint(127.0 * (cloud.directions + 1.0)).astype(np.uint8)
    return pack({"points": zigzag(places), "directions": directions}, **box)


def slices_document(field: LevelSet | Density) -> Packed:
    """Describe a field by its three sections through the middle, one byte a sample; pure.

    Of a level set the signed distance [m], limited to the band; of a density the length of hair a volume [m/m^3].
    """
    values, low, cell = samples_of(field)
    limit = float(np.abs(values).max(initial=0.0)) or 1.0
    bottom = -limit if isinstance(field, LevelSet) else 0.0
    steps = np.rint((values - bottom) * (255.0 / (limit - bottom))).astype(np.uint8)
    sections = {f"section{axis}": np.take(steps, steps.shape[axis] // 2, axis=axis) for axis in range(3)}
    return pack(sections, low=low.tolist(), cell=cell, bottom=bottom, top=limit, signed=isinstance(field, LevelSet))


def surface_of(field: LevelSet) -> Mesh:
    """Return the zero surface of a level set, empty for a field without an inside; pure."""
    values, low, cell = samples_of(field)
    stride = 1
    while values[::stride, ::stride, ::stride].size > MOST_SAMPLES:
        stride += 1
    coarse = np.pad(values[::stride, ::stride, ::stride], 1, constant_values=float(field.voxel * field.half_width))
    if not (coarse < 0.0).any():
        return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    axes = tuple(low[a] + cell * stride * (np.arange(n) - 1) for a, n in enumerate(coarse.shape))
    return Mesh(*extract_surface(coarse, axes))  # type: ignore[arg-type]


def samples_of(field: LevelSet | Density) -> tuple[np.ndarray, np.ndarray, float]:
    """Return all samples of a field on a dense grid, the place of the first [m], (3,), and their spacing [m]; pure."""
    if isinstance(field, Density):
        return field.length, field.cell * field.low.astype(float), field.cell
    band = field.voxel * field.half_width
    blocks = np.where(field.bricks == LevelSet.FAR_INSIDE, -band, band).astype(np.float32)
    dense = np.broadcast_to(blocks[..., None, None, None], (*blocks.shape, 8, 8, 8)).copy()
    near = field.bricks >= 0
    dense[near] = field.distance[field.bricks[near], :8, :8, :8]
    na, nb, nc = blocks.shape
    return dense.transpose(0, 3, 1, 4, 2, 5).reshape(8 * na, 8 * nb, 8 * nc), field.origin, field.voxel


MEDIA = {
    b"\x89PNG": ".png",
    b"\xff\xd8\xff": ".jpg",
    b"RIFF": ".webp",
    b"<svg": ".svg",
    b"<?xml": ".svg",
}
"""Suffixes of pictures, by their first bytes."""
TYPES = {".png": "image/png", ".jpg": "image/jpeg", ".webp": "image/webp", ".svg": "image/svg+xml"}
KINDS: dict[type, tuple[str, ...]] = {
    Strands: ("strands",),
    Groom: ("strands", "maps"),
    Mesh: ("mesh",),
    Body: ("mesh", "maps"),
    LevelSet: ("slices", "surface"),
    Density: ("slices",),
    Cloud: ("points",),
    Particles: ("points",),
    Table: ("table",),
    PointValues: ("values",),
    HairState: ("value", "contacts"),
}
"""Documents of values by their type; other types have `value`, a summary."""


def kinds_of(kind: type) -> tuple[str, ...]:
    """List the documents of a value of a type; none for a file, which a browser may show itself."""
    return () if kind is File else KINDS.get(kind, ("value",))


def suffix_of(path: Path) -> str | None:
    """Return the suffix of a picture by its bytes, independent of its name; None for other or missing files."""
    try:
        with path.open("rb") as file:
            head = file.read(8)
    except OSError:
        return None
    return next((suffix for mark, suffix in MEDIA.items() if head.startswith(mark)), None)


def mesh_of(kind: str, value: Any) -> Mesh | None:
    """Return the mesh that a document of a value describes; None for a document without triangles."""
    if kind == "surface":
        return surface_of(value)
    mesh = value.mesh if isinstance(value, Body) else value
    return mesh if kind == "mesh" else None


def document_of(kind: str, value: Any, most: int) -> Packed:
    """Describe a value in one document; meshes have two of their own.

    most  maximum number of shown strands
    """
    make: dict[str, Callable[[], Packed]] = {
        "strands": lambda: strands_document(value, most),
        "points": lambda: points_document(value),
        "values": lambda: values_document(value, most),
        "contacts": lambda: pack({"segments": value.stuck.astype(np.uint32)}),
        "slices": lambda: slices_document(value),
        "table": lambda: ({"names": list(value.names), "rows": [[*map(plain, row)] for row in value.rows()]}, b""),
        "maps": lambda: maps_document(value),
        "value": lambda: ({"lines": list(summary_lines(value))}, b""),
    }
    return make[kind]()


def plain(cell: Any) -> Any:
    return str(cell) if isinstance(cell, float) and not math.isfinite(cell) else cell


def summary_lines(value: Any, prefix: str = "") -> list[list[str]]:
    """List the arrays and numbers in a value: name, shape and type, least and largest."""
    if isinstance(value, np.ndarray):
        numbers = value[np.isfinite(value)] if value.dtype.kind == "f" else value
        spread = f"{numbers.min():.6g} ... {numbers.max():.6g}" if numbers.size and numbers.dtype.kind in "iufb" else ""
        return [[prefix, f"{' x '.join(map(str, value.shape))} {value.dtype}", spread]]
    if dataclasses.is_dataclass(value) or (isinstance(value, tuple) and hasattr(value, "_fields")):
        names = getattr(value, "_fields", None) or [field.name for field in dataclasses.fields(value)]  # type: ignore[arg-type]
        return [line for name in names for line in summary_lines(getattr(value, name), f"{prefix}.{name}".lstrip("."))]
    if isinstance(value, dict):
        return [line for name, inner in value.items() for line in summary_lines(inner, f"{prefix}[{name}]")]
    return [[prefix, type(value).__name__, str(value)[:200]]]


class Origin(NamedTuple):
    """Origin of an object: an output of a result of a shot."""

    shot: GraphShot
    task: Task
    record: Record
    output: str

    @property
    def kind(self) -> type:
        return self.shot.graph.nodes[self.task.node].type.outputs[self.output]


class Shelf:
    """Cached results of shots, as documents named `OBJECT.KIND`.

    most  maximum number of shown strands of a groom
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self._places: dict[str, Origin] = {}
        self._faces: dict[str, Packed] = {}
        self._suffixes: dict[str, str | None] = {}

    def take(self, shot: GraphShot, found: Plan) -> None:
        """Add the results of a plan of a shot; earlier ones are kept."""
        for task, record in found.records.items():
            for name, output in record.outputs.items():
                self._places[output.object] = Origin(shot, task, record, name)

    def names(self) -> Iterator[str]:
        """Iterate over the names of all documents except triangles, which are known once a mesh was made."""
        for name, place in self._places.items():
            if place.shot.object_path(name).exists():
                yield from (f"{name}.{document}" for document in kinds_of(place.kind))

    def node_of(self, name: str) -> str:
        return self._places[name.rpartition(".")[0]].task.node

    def faces(self) -> dict[str, Packed]:
        """Documents of the triangles of all requested meshes, by name."""
        return dict(self._faces)

    def suffix(self, name: str) -> str | None:
        """Suffix of an object that is a picture, else None."""
        if name not in self._suffixes and name.endswith(".bin"):
            self._suffixes[name] = suffix_of(self._places[name].shot.object_path(name))
        return self._suffixes.get(name)

    def picture(self, name: str) -> bytes:
        """Read a picture by the name of its object; KeyError for an unknown one."""
        file = self._read(name)
        if not isinstance(file, File) or not self.suffix(name):
            raise KeyError(name)
        return file.path.read_bytes()

    def document(self, name: str, most: int | None = None) -> Packed:
        """Make a document by its name, optionally with another number of strands; KeyError for an unknown name.

        BadInput for a missing or damaged object, which the next run computes again.
        """
        whose, _, kind = name.rpartition(".")
        if kind == "faces":
            return self._faces[whose]
        value = self._read(whose)
        if kind not in kinds_of(self._places[whose].kind):
            raise KeyError(name)
        mesh = mesh_of(kind, value)
        if mesh is None:
            return document_of(kind, value, self.most if most is None else most)
        found = mesh_document(mesh)
        self._faces.setdefault(found[0]["faces"], faces_document(mesh))
        return found

    def _read(self, name: str) -> Any:
        place = self._places[name]
        try:
            return place.shot.read(place.task, place.record, place.output)
        except FileNotFoundError as error:
            raise BadInput("is no longer in the cache", where=name, right="a run, which computes it again") from error
