"""OBJ or PLY files, a numbered sequence or one alone: polygons of the first file, points of each."""

import hashlib
import warnings
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.files import alone, is_sequence, numbered
from hairpipe.io.mesh_cache.moving import Points, Shape
from hairpipe.io.mesh_cache.ply_mesh import read_ply_mesh, read_ply_points
from hairpipe.io.obj import read_polygons
from hairpipe.io.text import LARGEST, MOST_BYTES, parse_number
from hairpipe.plain_file import content, stamp_of


class Sequence:
    """Samples of a sequence, see `hairpipe.io.mesh_cache.moving.Source`; the number of a file is its time code.

    A file alone, whose path has no mark for a number, is a sequence of one: a mesh that holds still.

    Raises BadInput for a sequence without files; warns of missing numbers, and of one file of many.
    """

    own = (False,)

    def __init__(self, path: Path, group: str | None, fps: float) -> None:
        files = numbered(path) if is_sequence(path) else alone(path)
        self.group, self.rate = group, fps
        self.files = list(files.values())
        self.read_shape, self.read_points = READERS[path.suffix.lower()]
        self.codes = np.array(list(files), np.float64)
        self.first = recall_first(self.files[0], group, stamp_of(str(self.files[0])))
        gaps = np.diff(self.codes)
        if len(gaps) and gaps.max() > gaps.min():
            after = int(self.codes[np.argmax(gaps)])
            message = f"{path}: files after number {after} are missing: points are interpolated over the gap"
            warnings.warn(message, stacklevel=2)

    def shape(self, sample: int) -> Shape:
        """Read the triangles at a sample, and all points there."""
        return self.read_shape(self.files[sample], self.group) if sample else self.first.shape

    def sample(self, sample: int) -> list[Points]:
        """Read the points of a file; BadInput where its faces are not those of the first one."""
        file = self.files[sample]
        first = self.files[0].name
        points, faces = self.read_points(file)
        if len(points) != len(self.first.shape.mesh.points):
            right = f"{len(self.first.shape.mesh.points):,} as {first} has"
            raise BadInput(f"the file has {len(points):,} vertices", where=file, right=right)
        if faces != self.first.faces:
            raise BadInput("the faces have changed", where=file, right=f"those of {first}")
        return [(points, None)]


class First(NamedTuple):
    """Triangles of the first file, and digest of its polygons."""

    shape: Shape
    faces: bytes


@lru_cache(maxsize=1)
def recall_first(path: Path, group: str | None, stamp: tuple[int, ...]) -> First:
    """Read the first file once per process, as long as its stamp is the same."""
    read_shape, read_points = READERS[path.suffix.lower()]
    return First(read_shape(path, group), read_points(path)[1])


def read_obj_shape(path: Path, group: str | None = None) -> Shape:
    """Read the triangles of an OBJ file, or of a group of it."""
    return Shape(*read_polygons(path, group))


def read_obj_points(path: Path) -> tuple[np.ndarray, bytes]:
    """Return the vertices of an OBJ file, (n, 3) float64, and a digest of its faces.

    Raises BadInput, with the line, where one is not three numbers.
    """
    vertices: list[list[bytes]] = []
    lines: list[int] = []
    faces = hashlib.blake2b()
    for number, line in enumerate(content(path, "an OBJ file", MOST_BYTES).splitlines(), start=1):
        words = line.split()
        if words and words[0] == b"v":
            vertices.append(words[1:4])
            lines.append(number)
        elif words and words[0] == b"f":
            faces.update(b" ".join(words) + b"\n")
    try:
        points = np.array(vertices, np.float64).reshape(-1, 3)
    except ValueError:
        points = np.full((len(vertices), 3), np.nan)
    if not (np.abs(points) <= LARGEST).all():
        _name_fault(path, vertices, lines)
    return points, faces.digest()


def _name_fault(path: Path, vertices: list[list[bytes]], lines: list[int]) -> None:
    """Raise BadInput for the first vertex that is not three usable numbers."""
    for words, line in zip(vertices, lines, strict=True):
        texts = [word.decode("latin-1") for word in words]
        if len(texts) < 3 or None in map(parse_number, texts):
            what = f"{' '.join(texts)[:60]!r} are not three usable numbers"
            raise BadInput(what, where=f"{path}, line {line}", right="v x y z")


READERS = {".obj": (read_obj_shape, read_obj_points), ".ply": (read_ply_mesh, read_ply_points)}
"""Readers of triangles, and of points with a digest of the polygons, by suffix."""
