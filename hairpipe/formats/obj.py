"""Wavefront files (.obj): polygons with texture coordinates and groups, as text."""

import hashlib
import re
import warnings
from collections import Counter
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.polygons import Polygons, triangulate
from hairpipe.formats.text import LARGEST, parse_number, parse_numbers, read_text
from hairpipe.values import Mesh

NAMED = 8  # kinds of statements in a message
BLANKS = b" \t\n\v\f"
NOT_READ = ("vn", "s", "usemtl", "mtllib")
"""Statements of normals and materials, which are not used."""
WIDTH = max(map(len, NOT_READ)) + 1
"""Letters of a keyword that are compared: as many as ours have, and one more."""


def read_polygons(path: Path, group: str | None = None) -> Polygons:
    """Read the triangles of a file, or of one group or object of it, and all vertices of the file, in its order.

    Polygons are cut into triangles. Texture coordinates are kept if all of these faces have them.
    Raises BadInput, with the line, where the file cannot be read or is not a mesh.
    """
    return _Obj(path).mesh(group)


def read_points(path: Path) -> tuple[np.ndarray, bytes]:
    """Return the vertices of a file, (n, 3) float64, and a digest of its faces; BadInput as `read_polygons`."""
    file = _Obj(path)
    faces = file.items("f", least=3)
    return file.points, hashlib.blake2b(faces.corners.tobytes() + faces.sizes.tobytes()).digest()


class Lines(NamedTuple):
    """Lines of a file.

    points   vertices of the file, (n, 3) float64
    corners  vertices of the lines, one line after the other, (c,) int64
    sizes    number of vertices of each line, (m,) int64
    owners   group or object of each line, an index of `names`, (m,) int64
    """

    points: np.ndarray
    corners: np.ndarray
    sizes: np.ndarray
    owners: np.ndarray
    names: list[str]


def read_lines(path: Path) -> Lines:
    """Read the vertices and the lines (l), with their groups or objects; BadInput, with the line, without any."""
    file = _Obj(path)
    lines = file.items("l", least=2)
    if not len(lines.sizes):
        raise BadInput("there are no lines", where=path, right="an OBJ file with v and l statements")
    owners, groups = file.groups(lines.statements)
    names = {" ".join(names): place for place, names in enumerate(groups)}
    places = np.array([list(names).index(" ".join(group)) for group in groups])
    return Lines(file.points, lines.corners, lines.sizes, places[owners], list(names))


class _Items(NamedTuple):
    """Faces or lines: their statements, and the corners of all; texture coordinates are -1 where there are none."""

    statements: np.ndarray
    sizes: np.ndarray
    corners: np.ndarray
    texture: np.ndarray


class _Obj:
    """Statements of a file as arrays: a list of Python objects takes thirty times as much memory as the text.

    data    the text, with comments and joined lines as blanks
    starts  places of the words, (w,)
    firsts  first word of each statement, (s,), and the total; keywords  of the statements, (s,)
    points  (n, 3) float64
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        text = re.sub(rb"#[^\n]*", blanks, read_text(path).encode() + b"\n")
        self.data = np.frombuffer(re.sub(rb"\\[ \t\v\f]*\n", blanks, text), np.uint8)
        is_blank = np.isin(self.data, np.frombuffer(BLANKS, np.uint8))
        self.ends = np.flatnonzero(self.data == ord("\n")).astype(np.int32)
        self.starts = np.flatnonzero(~is_blank & np.insert(is_blank[:-1], 0, True)).astype(np.int32)
        self.stops = np.flatnonzero(~is_blank & np.append(is_blank[1:], True)).astype(np.int32) + 1
        lines = np.searchsorted(self.ends, self.starts)
        self.firsts = np.append(np.flatnonzero(np.diff(lines, prepend=-1)), len(lines))
        heads = self.firsts[:-1]
        places = self.starts[heads, None] + np.arange(WIDTH)
        letters = self.data[np.minimum(places, len(self.data) - 1)]
        letters = np.where(places < self.stops[heads, None], letters, 0)
        self.keywords = np.ascontiguousarray(letters).view(f"S{WIDTH}")[:, 0]
        self.lines = text
        # A number that one parser reads and another one does not.
        self.unusable = BadInput("a number is not usable", where=path, right="decimal numbers")
        self.points = self.numbers("v", 3, 3)

    def statements(self, keyword: str) -> np.ndarray:
        return np.flatnonzero(self.keywords == keyword.encode())

    def words(self, statement: int) -> list[str]:
        """Return the words of a statement after its keyword."""
        places = range(self.firsts[statement] + 1, self.firsts[statement + 1])
        return [self.data[self.starts[n] : self.stops[n]].tobytes().decode() for n in places]

    def text_of(self, chosen: np.ndarray, begins: np.ndarray, stops: np.ndarray) -> bytes:
        """Return the text in which all but chosen places are blanks."""
        edges = np.zeros(len(self.data) + 1, np.int8)
        edges[begins[chosen]] += 1
        edges[stops[chosen]] -= 1
        return np.where(np.cumsum(edges[:-1], dtype=np.int8).view(bool), self.data, np.uint8(ord(" "))).tobytes()

    def numbers(self, keyword: str, least: int, most: int) -> np.ndarray:
        """Return the numbers of the statements of a keyword, (k, most), and 0 for those that are omitted."""
        statements = self.statements(keyword)
        counts = np.minimum(np.diff(self.firsts)[statements] - 1, most)
        chosen = np.concatenate([self.firsts[statements] + n for n in range(1, most + 1)])
        chosen = np.sort(chosen[np.concatenate([counts >= n for n in range(1, most + 1)])])
        values = parse_numbers(self.text_of(chosen, self.starts, self.stops), len(chosen))
        if values is None or (counts < least).any() or not (np.abs(values) <= LARGEST).all():
            raise next(self.bad_numbers(statements, least, most))
        table = np.zeros((len(statements), most))
        table[np.arange(most) < counts[:, None]] = values
        return table

    def bad_numbers(self, statements: np.ndarray, least: int, most: int) -> Iterator[BadInput]:
        for statement in statements.tolist():
            words = self.words(statement)[:most]
            if len(words) < least or None in map(parse_number, words):
                what = f"{' '.join(words)[:60]!r} are not {least} usable numbers"
                yield self.fault(statement, what, "v x y z, vt u v")
        yield self.unusable

    def items(self, keyword: str, least: int) -> _Items:
        """Return the faces (f) or lines (l): corners i, i/j, i//k or i/j/k."""
        statements = self.statements(keyword)
        sizes = np.diff(self.firsts)[statements] - 1
        if (sizes < least).any():
            bad = int(np.argmax(sizes < least))
            name, right = ("face", "three or more") if keyword == "f" else ("line", "two or more")
            item = "corners" if keyword == "f" else "vertices"
            raise self.fault(statements[bad], f"a {name} has {sizes[bad]} {item}", right)
        owners = np.repeat(np.arange(len(statements)), sizes)
        words = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        words += self.firsts[statements[owners]] + 1
        slashes = np.flatnonzero(self.data == ord("/"))
        first, last = (np.searchsorted(slashes, places[words]) for places in (self.starts, self.stops))
        marks = np.append(slashes, [len(self.data)] * 2)
        ends = np.where(last > first, marks[first], self.stops[words])
        begins = np.where(last > first, marks[first] + 1, ends)
        stops = np.where(last > first + 1, marks[first + 1], self.stops[words])
        given = [self.starts[words] < ends, begins < stops]
        counts = [np.searchsorted(self.statements(name), statements[owners]) for name in ("v", "vt")]
        found = []
        for has, begin, stop, count in zip(given, (self.starts[words], begins), (ends, stops), counts, strict=True):
            chosen = np.flatnonzero(has)
            values = parse_numbers(self.text_of(chosen, begin, stop), len(chosen), np.int64)
            most = count[chosen]
            if values is None or (values == 0).any() or (np.abs(values.astype(float)) > most).any():
                break
            found.append(np.full(len(words), -1))
            found[-1][chosen] = np.where(values > 0, values - 1, most + values)
        if len(found) < 2 or not given[0].all() or (last - first > 2).any():
            raise next(self.bad_corners(statements))
        return _Items(statements, sizes, *found)

    def bad_corners(self, statements: np.ndarray) -> Iterator[BadInput]:
        for statement, word in ((s, word) for s in statements for word in self.words(s)):
            parts = word.split("/")
            if len(parts) > 3:
                yield self.fault(statement, f"{word[:40]!r} is not a corner of a face", "i, i/j, i//k or i/j/k")
            for part, name in zip(parts, ("v", "vt"), strict=False):
                count = int(np.searchsorted(self.statements(name), statement))
                if name == "vt" and not part:
                    continue
                if not re.fullmatch(r"[+-]?[0-9]+", part):
                    yield self.fault(statement, f"{part[:40]!r} is not an index", "a whole number")
                elif not 1 <= abs(int(part[:20])) <= count:
                    right = f"1 to {count}, or -1 to -{count}"
                    yield self.fault(statement, f"index {part[:20]} does not exist", right)
        yield self.unusable

    def groups(self, statements: np.ndarray) -> tuple[np.ndarray, list[tuple[str, ...]]]:
        """Return the place of the groups and the object of each statement, (k,), in a list of these."""
        latest = [np.searchsorted(self.statements(name), statements) - 1 for name in "go"]
        pairs, places = np.unique(np.stack(latest, axis=1), axis=0, return_inverse=True)
        groups, objects = (self.statements(name) for name in "go")
        named = [
            (*(self.words(groups[g]) if g >= 0 else ()), *([" ".join(self.words(objects[o]))] if o >= 0 else ()))
            for g, o in pairs.tolist()
        ]
        return places.reshape(-1), named

    def mesh(self, group: str | None) -> Polygons:
        """Return the triangles of all faces or of a group, and the polygon of each."""
        coordinates = self.numbers("vt", 1, 2)
        faces = self.items("f", least=3)
        owners, groups = self.groups(faces.statements)
        is_read = np.array([group is None or group in names for names in groups], bool)[owners]
        if not is_read.any():
            raise self.missing(group, groups)
        sizes = faces.sizes[is_read]
        corners, texture = (values[np.repeat(is_read, faces.sizes)] for values in (faces.corners, faces.texture))
        chosen = triangulate(self.points[corners], sizes)
        triangles = corners[chosen].astype(np.int32)
        real = (triangles != triangles[:, (1, 2, 0)]).all(axis=1)
        if not real.any():
            what = "there is no triangle between three different vertices"
            raise self.fault(faces.statements[is_read][0], what, "faces of three corners or more")
        bare = np.logical_or.reduceat(texture < 0, np.cumsum(sizes) - sizes)
        self.warn_of_unread(int(bare.sum()), len(sizes))
        uv = None if bare.any() else coordinates.astype(np.float32)[texture][chosen][real]
        return Polygons(Mesh(self.points, triangles[real], uv=uv), np.repeat(np.arange(len(sizes)), sizes - 2)[real])

    def warn_of_unread(self, bare: int, faces: int) -> None:
        """Warn of statements that are not read, and of texture coordinates that only some corners have."""
        known = np.isin(self.keywords, [name.encode() for name in ("v", "vt", "f", "g", "o", "l", *NOT_READ)])
        heads = self.firsts[:-1][~known]
        unread = Counter(
            self.data[a : min(a + 20, b)].tobytes().decode(errors="replace")
            for a, b in zip(self.starts[heads].tolist(), self.stops[heads].tolist(), strict=True)
        )
        unread.update({"l": len(lines)} if len(lines := self.statements("l")) else {})
        if unread:
            named = ", ".join(f"{count} {word}" for word, count in sorted(unread.items())[:NAMED])
            warnings.warn(f"{self.path}: statements that are not read: {named}", stacklevel=4)
        if 0 < bare < faces:
            message = f"{bare} of {faces} faces have no texture coordinates: those of the others are not used"
            warnings.warn(f"{self.path}: {message}", stacklevel=4)

    def missing(self, group: str | None, groups: list[tuple[str, ...]]) -> BadInput:
        names = sorted({name for names in groups for name in names if name})
        if group is None or not names:
            return BadInput("there are no faces", where=self.path, right="an OBJ file with v and f lines")
        near = get_close_matches(group, names, n=3) or names[:8]
        return BadInput(f"there is no group {group!r}", where=self.path, right=f"for example {', '.join(near)}")

    def fault(self, statement: int, what: str, right: str) -> BadInput:
        """Return a fault with the line of a statement."""
        line = self.lines.count(b"\n", 0, int(self.starts[self.firsts[statement]])) + 1
        return BadInput(what, where=f"{self.path}, line {line}", right=right)


def blanks(match: re.Match[bytes]) -> bytes:
    return b" " * len(match[0])
