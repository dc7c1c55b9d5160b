"""Elements of Stanford PLY files (.ply), as text or binary, and meshes of them.

We read PLY ourselves: counts of a damaged header are checked before memory is taken, and rows of one size are read at
once.
"""

import hashlib
import re
import struct
from array import array
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.polygons import Polygons, triangulate, warn_of_unused
from hairpipe.formats.text import LARGEST, MOST_BYTES, parse_number, parse_numbers
from hairpipe.plain_file import content
from hairpipe.values import Mesh

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
LETTERS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
"""Characters of `struct` for the types."""
HEADER_BYTES = 1 << 16
DIGITS = "[0-9]{1,18}"
BLANKS = np.frombuffer(b" \t\n\v\f\r", np.uint8)


class Lists(NamedTuple):
    """A property whose rows are lists.

    counts  number of values of every row, (n,) int64
    values  of all rows, one row after the other
    """

    counts: np.ndarray
    values: np.ndarray


class Property(NamedTuple):
    """Name and type of a property; `length` is the type of the length of a list."""

    name: str
    kind: str
    length: str | None = None


class Element(NamedTuple):
    """Name, number of rows and properties of an element."""

    name: str
    rows: int
    properties: list[Property]


Columns = dict[str, np.ndarray | Lists]
"""Properties of an element by their names, (n,) each, or lists."""


def read_ply(path: Path) -> dict[str, Columns]:
    """Return the properties of all elements, by the names of these; BadInput where the file is damaged."""
    data = content(path, "a .ply file")
    order, elements, begin = read_header(data, path)
    if not order and len(data) > MOST_BYTES:
        right = f"a binary one, or text of at most {MOST_BYTES:,} bytes"
        raise BadInput(f"the file is too large: {len(data):,} bytes", where=path, right=right)
    rows = Rows(data[begin:], order, path)
    columns = dict[str, Columns]()
    for element in filter(lambda element: element.properties, elements):
        if len({p.name for p in element.properties}) < len(element.properties):
            raise BadInput(f"two properties of {element.name} have one name", where=path, right="different names")
        columns[element.name] = rows.take(element)
    return columns


def read_header(data: bytes, path: Path) -> tuple[str, list[Element], int]:
    """Return the byte order ('' of text), the elements, and the byte at which their rows begin."""
    if data[:3] != b"ply":
        raise BadInput("the file does not begin with 'ply'", where=f"{path}, byte 0", right="a .ply file")
    form = ""
    elements = list[Element]()
    begin = 0
    for number, line in enumerate(data[:HEADER_BYTES].splitlines(keepends=True), start=1):
        begin += len(line)
        match line.decode("latin-1").split():
            case ["end_header"] if form:
                return ORDERS[form], elements, begin
            case ["format", name, _] if name in ORDERS:
                form = name
            case ["element", name, count] if re.fullmatch(DIGITS, count):
                elements.append(Element(name, int(count), []))
            case ["property", "list", length, kind, name] if elements and {length, kind} <= TYPES.keys():
                elements[-1].properties.append(Property(name, TYPES[kind], TYPES[length]))
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1].properties.append(Property(name, TYPES[kind]))
            case [] | ["ply"] | ["comment" | "obj_info", *_]:
                pass
            case words:
                right = f"format {' or '.join(ORDERS)} 1.0, element NAME COUNT, property TYPE NAME, end_header"
                what = f"{' '.join(words)[:60]!r} is not a statement of a header"
                raise BadInput(what, where=f"{path}, line {number}", right=right)
    raise BadInput("the header does not end", where=path, right="a line end_header")


class Rows:
    """Values of a file in units of bytes, or of numbers of a text, read one element after the other.

    order  of the bytes, '' of text
    data   units, (n,) uint8 or float64; buffer  the same for access one by one
    at     first unit that is not read yet
    """

    def __init__(self, data: bytes, order: str, path: Path) -> None:
        self.order, self.path, self.at = order, path, 0
        self.data = np.frombuffer(data, np.uint8) if order else _numbers_in(data, path)
        self.buffer: Any = data if order else self.data.data

    def size(self, kind: str) -> int:
        """Return the number of units of a value."""
        return int(kind[1]) if self.order else 1

    def number(self, kind: str, at: int) -> float:
        return struct.unpack_from(self.order + LETTERS[kind], self.buffer, at)[0] if self.order else self.buffer[at]

    def decode(self, units: np.ndarray, kind: str) -> np.ndarray:
        if self.order:
            whole = len(units) // self.size(kind) * self.size(kind)
            return np.ascontiguousarray(units[:whole]).view(self.order + kind)
        with np.errstate(invalid="ignore"):
            return units.astype(kind)

    def take(self, element: Element) -> Columns:
        """Return the properties of an element, whose rows are next."""
        needed = element.rows * sum(self.size(p.length or p.kind) for p in element.properties)
        left = len(self.data) - self.at
        if needed > left:
            what = f"{element.rows} rows of {element.name} need {needed} values or bytes more, the file has {left}"
            raise BadInput(what, where=self.path, right="a whole file")
        if not element.rows:
            none = np.empty(0, np.int64)
            return {p.name: Lists(none, none) if p.length else none for p in element.properties}
        spans = self._spans(element)
        begin, self.at = self.at, int(spans[-1, -1, 1])
        columns: Columns = {}
        for p, span in zip(element.properties, spans.swapaxes(0, 1), strict=True):
            begins, ends = span.T
            values = self.decode(self._between(begins, ends, begin), p.kind)
            columns[p.name] = Lists((ends - begins) // self.size(p.kind), values) if p.length else values
        return columns

    def _between(self, begins: np.ndarray, ends: np.ndarray, first: int) -> np.ndarray:
        """Return the units of all rows from a begin to an end, which follow each other."""
        edges = np.zeros(self.at - first + 1, np.int8)
        filled = begins < ends
        edges[begins[filled] - first] += 1
        edges[ends[filled] - first] -= 1
        return self.data[first : self.at][np.cumsum(edges[:-1], dtype=np.int8).view(bool)]

    def _spans(self, element: Element) -> np.ndarray:
        """Return where the values of each property begin and end, (rows, properties, 2): at once for equal rows."""
        first = self._follow(element, 1)
        width = int(first[0, -1, 1]) - self.at
        if (len(self.data) - self.at) // width >= element.rows:
            table = self.data[self.at : self.at + element.rows * width].reshape(element.rows, width)
            begins = zip(element.properties, first[0, :, 0] - self.at, strict=True)
            heads = [table[:, begin - self.size(p.length) : begin] for p, begin in begins if p.length]
            if all((head == head[0]).all() for head in heads):
                return first + width * np.arange(element.rows)[:, None, None]
        return self._follow(element, element.rows)

    def _follow(self, element: Element, rows: int) -> np.ndarray:
        """Return the spans of some rows, as of `_spans`, one after the other."""
        spans = array("q")
        at = self.at
        sizes = [(p.length, self.size(p.length or p.kind), self.size(p.kind)) for p in element.properties]
        for _ in range(rows):
            for length, size, item in sizes:
                begin = at + size if length else at
                at = begin + (self._length(element, length, at) * item if length else size)
                spans.extend((begin, at))
        if at > len(self.data):
            what = f"the lists of {element.name} end {at - len(self.data)} values or bytes after the file"
            raise BadInput(what, where=self.path, right="a whole file")
        return np.array(spans, np.int64).reshape(rows, -1, 2)

    def _length(self, element: Element, kind: str, at: int) -> int:
        """Return the length of a list; BadInput where there is none or it is longer than the file."""
        found = self.number(kind, at) if at + self.size(kind) <= len(self.data) else -1
        if not 0 <= found <= len(self.data) or found != int(found):
            what = f"a list of {element.name} has {found:g} values"
            raise BadInput(what, where=self.path, right=f"0 to {len(self.data) - at}: the file has no more")
        return int(found)


def _numbers_in(text: bytes, path: Path) -> np.ndarray:
    count = np.count_nonzero(np.diff(np.isin(np.frombuffer(text, np.uint8), BLANKS).view(np.int8), prepend=1) < 0)
    found = parse_numbers(text, int(count))
    if found is None:
        bad = next((word for word in text.decode("latin-1").split() if parse_number(word) is None), "a word")
        raise BadInput(f"{bad[:20]!r} is not a number", where=path, right="numbers")
    return found


CORNERS = ("vertex_indices", "vertex_index")
KNOWN = ("x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha")


def read_ply_mesh(path: Path, group: str | None = None) -> Polygons:
    """Read the triangles of a file; BadInput where it has no polygons, or invalid ones."""
    if group is not None:
        raise BadInput("a PLY file has no groups", where=path, right="no group")
    elements = read_ply(path)
    points = vertices_of(elements, path)
    faces = polygons_of(elements, path)
    warn_of_unused(path, {*elements["vertex"], *elements["face"]} - {*KNOWN, *CORNERS})
    corners = faces.values.astype(np.int64)
    if not len(faces.counts) or faces.counts.min() < 3 or not 0 <= corners.min() <= corners.max() < len(points):
        right = f"polygons of 3 corners or more, of the vertices 0 to {len(points) - 1}"
        raise BadInput("a polygon is invalid", where=f"{path}, element face", right=right)
    triangles = corners[triangulate(points[corners], faces.counts)].astype(np.int32)
    return Polygons(Mesh(points, triangles), np.repeat(np.arange(len(faces.counts)), faces.counts - 2))


def read_ply_points(path: Path) -> tuple[np.ndarray, bytes]:
    """Return the vertices of a file, (n, 3) float64, and a digest of its polygons."""
    elements = read_ply(path)
    parts = (np.asarray(values, np.int64).tobytes() for values in polygons_of(elements, path))
    return vertices_of(elements, path), hashlib.blake2b(b"".join(parts)).digest()


def vertices_of(elements: dict[str, Columns], path: Path) -> np.ndarray:
    columns = [elements.get("vertex", {}).get(name) for name in "xyz"]
    if not all(isinstance(column, np.ndarray) for column in columns):
        raise BadInput("there are no positions", where=path, right="an element vertex with x, y and z")
    points = np.stack([np.asarray(column, np.float64) for column in columns], axis=1)
    bad = ~(np.abs(points) <= LARGEST).all(axis=1)
    if bad.any():
        raise BadInput(f"vertex {bad.argmax()} is not finite", where=path, right="finite numbers")
    return points


def polygons_of(elements: dict[str, Columns], path: Path) -> Lists:
    face = elements.get("face", {})
    found = next((face[name] for name in CORNERS if name in face), None)
    if not isinstance(found, Lists):
        right = f"an element face with a list {' or '.join(CORNERS)}"
        raise BadInput("there are no polygons", where=path, right=right)
    return found
