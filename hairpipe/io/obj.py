"""Wavefront files (.obj): polygons with texture coordinates and groups, as text."""

import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.io.polygons import triangulate
from hairpipe.io.text import parse_number, read_text

NAMED = 8  # kinds of statements in a message


def read_obj(path: Path, group: str | None = None) -> Mesh:
    """Read the triangles of a file, or of one group or object of it, and all vertices of the file, in its order.

    Polygons are cut into triangles. Texture coordinates are kept if all of these faces have them.
    Raises BadInput, with the line, where the file cannot be read or is not a mesh.
    """
    return read_polygons(path, group)[0]


def read_polygons(path: Path, group: str | None) -> tuple[Mesh, np.ndarray]:
    """Read a mesh as `read_obj` does, and the polygon of each of its m triangles, (m,) int64."""
    file = _Obj(path)
    file.read()
    return file.mesh(group)


def read_lines(path: Path) -> tuple[np.ndarray, list[np.ndarray], list[str]]:
    """Read the vertices, (n, 3) float64, the lines (l) as indices of vertices, and the group or object of each line.

    Raises BadInput, with the line, where the file cannot be read or has no lines.
    """
    file = _Obj(path)
    file.read()
    if not file.lines:
        raise BadInput("there are no lines", where=path, right="an OBJ file with v and l statements")
    return np.array(file.points), [line for line, _ in file.lines], [group for _, group in file.lines]


@dataclass
class _Face:
    corners: list[int]
    texture: list[int | None]
    groups: tuple[str, ...]
    line: int


@dataclass
class _Obj:
    path: Path
    points: list[list[float]] = field(default_factory=list)
    coordinates: list[list[float]] = field(default_factory=list)
    faces: list[_Face] = field(default_factory=list)
    lines: list[tuple[np.ndarray, str]] = field(default_factory=list)
    groups: tuple[str, ...] = ()
    object: tuple[str, ...] = ()
    line: int = 0
    unread: Counter[str] = field(default_factory=Counter)

    def read(self) -> None:
        for line, words in _statements(read_text(self.path)):
            self.line = line
            match words[0]:
                case "v":
                    self.points.append(self.numbers(words[1:], least=3, most=3))
                case "vt":
                    self.coordinates.append([*self.numbers(words[1:], least=1, most=2), 0.0][:2])
                case "f":
                    self.add_face(words[1:])
                case "l":
                    self.add_line(words[1:])
                case "g":
                    self.groups = tuple(words[1:])
                case "o":
                    self.object = (" ".join(words[1:]),)
                case "vn" | "s" | "usemtl" | "mtllib":
                    pass  # normals and materials are not used
                case other:
                    self.unread[other] += 1

    def numbers(self, words: list[str], least: int, most: int) -> list[float]:
        values = [value for word in words[:most] if (value := parse_number(word)) is not None]
        if len(values) < max(least, len(words[:most])):
            raise self.fault(f"{' '.join(words)[:60]!r} are not {least} usable numbers", "v x y z, vt u v")
        return values

    def add_face(self, words: list[str]) -> None:
        corners = [self.corner(word) for word in words]
        if len(corners) < 3:
            raise self.fault(f"a face has {len(corners)} corners", "three or more")
        points, texture = zip(*corners, strict=True)
        self.faces.append(_Face(list(points), list(texture), self.groups + self.object, self.line))

    def add_line(self, words: list[str]) -> None:
        if len(words) < 2:
            raise self.fault(f"a line has {len(words)} vertices", "two or more")
        vertices = np.array([self.corner(word)[0] for word in words])
        self.lines.append((vertices, " ".join(self.groups + self.object)))

    def corner(self, word: str) -> tuple[int, int | None]:
        """Indices from 0 of the vertex and of the texture coordinate: i, i/j, i//k or i/j/k."""
        parts = word.split("/")
        if len(parts) > 3:
            raise self.fault(f"{word[:40]!r} is not a corner of a face", "i, i/j, i//k or i/j/k")
        texture = self.index(parts[1], len(self.coordinates)) if len(parts) > 1 and parts[1] else None
        return self.index(parts[0], len(self.points)), texture

    def index(self, word: str, count: int) -> int:
        """Convert an index of the file, from 1 or negative from the last one so far, to one from 0."""
        try:
            number = int(word)
        except ValueError:
            raise self.fault(f"{word[:40]!r} is not an index", "a whole number") from None
        if not 1 <= abs(number) <= count:
            raise self.fault(f"index {word[:20]} does not exist", f"1 to {count}, or -1 to -{count}")
        return number - 1 if number > 0 else count + number

    def mesh(self, group: str | None) -> tuple[Mesh, np.ndarray]:
        faces = [face for face in self.faces if group is None or group in face.groups]
        if not faces:
            raise self.missing(group)
        points = np.array(self.points)
        sizes = np.array([len(face.corners) for face in faces])
        corners = np.array([corner for face in faces for corner in face.corners], np.int32)
        chosen = triangulate(points[corners], sizes)
        triangles = corners[chosen]
        real = (triangles != triangles[:, (1, 2, 0)]).all(axis=1)
        if not real.any():
            what = "there is no triangle between three different vertices"
            raise BadInput(what, where=f"{self.path}, line {faces[0].line}", right="faces of three corners or more")
        self.warn_of_unread(faces)
        texture = [corner for face in faces for corner in face.texture if corner is not None]
        uv = None if len(texture) < len(corners) else np.array(self.coordinates, np.float32)[texture][chosen][real]
        return Mesh(points, triangles[real], uv=uv), np.repeat(np.arange(len(sizes)), sizes - 2)[real]

    def warn_of_unread(self, faces: list[_Face]) -> None:
        """Warn of statements that are not read, and of texture coordinates that only some corners have."""
        self.unread.update({"l": len(self.lines)} if self.lines else {})
        if self.unread:
            named = ", ".join(f"{count} {word[:20]}" for word, count in sorted(self.unread.items())[:NAMED])
            warnings.warn(f"{self.path}: statements that are not read: {named}", stacklevel=4)
        bare = sum(None in face.texture for face in faces)
        if 0 < bare < len(faces):
            message = f"{bare} of {len(faces)} faces have no texture coordinates: those of the others are not used"
            warnings.warn(f"{self.path}: {message}", stacklevel=4)

    def missing(self, group: str | None) -> BadInput:
        names = sorted({name for face in self.faces for name in face.groups if name})
        if group is None or not names:
            return BadInput("there are no faces", where=self.path, right="an OBJ file with v and f lines")
        near = get_close_matches(group, names, n=3) or names[:8]
        return BadInput(f"there is no group {group!r}", where=self.path, right=f"for example {', '.join(near)}")

    def fault(self, what: str, right: str) -> BadInput:
        return BadInput(what, where=f"{self.path}, line {self.line}", right=right)


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Words of every statement with the number of its first line: comments gone, continued lines joined."""
    pending: list[str] = []
    first = 1
    for number, line in enumerate(text.split("\n"), start=1):
        line = line.split("#", 1)[0].strip()
        if not pending:
            first = number
        pending += line.removesuffix("\\").split()
        if pending and not line.endswith("\\"):
            yield first, pending
            pending = []
    if pending:
        yield first, pending
