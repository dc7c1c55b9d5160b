"""Elements of Stanford PLY files (.ply), as text or binary.

ply
format binary_little_endian 1.0
element vertex 3
property float x
element face 1
property list uchar int vertex_indices
end_header
"""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.io.text import MOST_BYTES
from hairpipe.plain_file import content

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
HEADER_BYTES = 1 << 16


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
    """Return the properties of all elements, by the names of these.

    Raises BadInput, with the line or byte, where the header or the number of values is wrong.
    """
    data = content(path, "a .ply file")
    order, elements, begin = read_header(data, path)
    if order:
        rows: Rows = BinaryRows(data, order, path, begin)
    elif len(data) <= MOST_BYTES:
        rows = TextRows(data[begin:].split(), path)
    else:
        right = f"a binary one, or text of at most {MOST_BYTES:,} bytes"
        raise BadInput(f"the file is too large: {len(data):,} bytes", where=path, right=right)
    return {element.name: read_element(element, rows) for element in elements if element.properties}


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
            case ["element", name, count] if count.isdecimal():
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


def read_element(element: Element, rows: "Rows") -> Columns:
    """Return the properties of an element, whose rows are next."""
    names = [p.name for p in element.properties]
    if len(set(names)) < len(names):
        raise BadInput(f"two properties of {element.name} have one name", where=rows.path, right="different names")
    if not any(p.length for p in element.properties):
        return rows.table(element)
    rows.check(element, element.rows * len(names))
    values: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for _ in range(element.rows):
        for p in element.properties:
            count = int(rows.take(element, p.length, 1)[0]) if p.length else 1
            values[p.name].append(rows.take(element, p.kind, count))
    columns = {name: np.concatenate([*found, np.empty(0)]) for name, found in values.items()}
    return {
        p.name: Lists(np.array([len(row) for row in values[p.name]], np.int64), columns[p.name])
        if p.length
        else columns[p.name]
        for p in element.properties
    }


class Rows(ABC):
    """Values of a file, read one after the other."""

    path: Path

    @property
    @abstractmethod
    def left(self) -> int:
        """Return the number of bytes, or words, that are not read yet."""

    @abstractmethod
    def take(self, element: Element, kind: str, count: int) -> np.ndarray:
        """Return the next values of a type, (count,)."""

    @abstractmethod
    def table(self, element: Element) -> Columns:
        """Return the properties of an element without lists."""

    def check(self, element: Element, needed: int) -> None:
        """Raise BadInput where an element needs more bytes, or words, than are left."""
        if not 0 <= needed <= self.left:
            what = f"{element.rows} rows of {element.name} need {needed} values or bytes more, the file has {self.left}"
            raise BadInput(what, where=self.path, right="a whole file")


class BinaryRows(Rows):
    """Values of a binary file from a byte on."""

    def __init__(self, data: bytes, order: str, path: Path, at: int) -> None:
        self.data, self.order, self.path, self.at = data, order, path, at

    @property
    def left(self) -> int:
        """Return the number of values that are not read yet."""
        return len(self.data) - self.at

    def take(self, element: Element, kind: str, count: int) -> np.ndarray:
        """Return the next values of a type, (count,)."""
        found = np.dtype(self.order + kind)
        self.check(element, count * found.itemsize)
        self.at += count * found.itemsize
        return np.frombuffer(self.data, found, count, self.at - count * found.itemsize)

    def table(self, element: Element) -> Columns:
        """Return the properties of an element without lists."""
        kind = np.dtype([(p.name, self.order + p.kind) for p in element.properties])
        self.check(element, element.rows * kind.itemsize)
        rows = np.frombuffer(self.data, kind, element.rows, self.at)
        self.at += rows.nbytes
        return {p.name: rows[p.name] for p in element.properties}


class TextRows(Rows):
    """Words of a text file."""

    def __init__(self, words: list[bytes], path: Path) -> None:
        self.words, self.path, self.at = words, path, 0

    @property
    def left(self) -> int:
        """Return the number of values that are not read yet."""
        return len(self.words) - self.at

    def take(self, element: Element, kind: str, count: int) -> np.ndarray:
        """Return the next values of a type, (count,)."""
        self.check(element, count)
        words = self.words[self.at : self.at + count]
        self.at += count
        try:
            with np.errstate(invalid="ignore"):
                return np.array(words, "S32").astype(np.float64).astype(kind)
        except ValueError:
            bad = next(word for word in words if not _is_number(word))
            what = f"{bad[:20].decode('latin-1')!r} in element {element.name} is not a number"
            raise BadInput(what, where=self.path, right="numbers") from None

    def table(self, element: Element) -> Columns:
        """Return the properties of an element without lists."""
        self.check(element, element.rows * len(element.properties))
        rows = self.take(element, "f8", element.rows * len(element.properties))
        columns = rows.reshape(element.rows, len(element.properties)).T
        return {p.name: column for p, column in zip(element.properties, columns, strict=True)}


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
