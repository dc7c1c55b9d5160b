"""OBJ or PLY files as an animated mesh, in a sequence or one alone: polygons of the first file, points of each."""

import os
import re
import warnings
from pathlib import Path

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, Polygons, read_at
from hairpipe.formats.obj import read_points, read_polygons
from hairpipe.formats.ply import read_ply_mesh, read_ply_points

READERS = {".obj": (read_polygons, read_points), ".ply": (read_ply_mesh, read_ply_points)}
"""Readers of triangles, and of points with a digest of the polygons, by suffix."""
MARK = re.compile(r"#+")
LAST_NUMBER = re.compile(r"\d+(?=\.\w+$)")


class Sequence:
    """Samples of a sequence, see `animated_meshes.Samples`; the number of a file is its time code.

    A file alone, whose path has no mark for a number, is a sequence of one: a mesh that holds still.

    Raises BadInput for a sequence without files; warns of missing numbers, and of one file of many.
    """

    own = (False,)

    def __init__(self, path: Path, group: str | None, fps: float) -> None:
        files = numbered(path) if is_sequence(path) else _alone(path)
        self.group, self.rate = group, fps
        self.files = list(files.values())
        self.read_shape, self.read_points = READERS[path.suffix.lower()]
        self.codes = np.array(list(files), np.float64)
        self.first = recall(First, self.files[0], group)
        gaps = np.diff(self.codes)
        if len(gaps) and gaps.max() > gaps.min():
            after = int(self.codes[np.argmax(gaps)])
            message = f"{path}: files after number {after} are missing: points are interpolated over the gap"
            warnings.warn(message, stacklevel=2)

    def shape(self, sample: int) -> Polygons:
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


class First:
    """Triangles of the first file, and digest of its polygons."""

    def __init__(self, path: Path, group: str | None) -> None:
        read_shape, read_points = READERS[path.suffix.lower()]
        self.files = [path]
        self.shape: Polygons = read_shape(path, group)
        self.faces = read_points(path)[1]


def read(path: Path, group: str | None, instant: Instant) -> Polygons:
    """Read the mesh of a sequence at an instant."""
    return read_at(Sequence(path, group, instant.fps), instant)


def is_sequence(path: Path) -> bool:
    """Whether a path is that of a numbered sequence; one without a mark for the number is that of a still mesh."""
    return path.suffix.lower() in READERS and MARK.search(path.name) is not None


def numbered(path: Path) -> dict[int, Path]:
    """Return the files of a sequence in the order of their numbers, which replace the only `####` of the name.

    Numbers may be longer than the mark, and negative. Links are followed to files of the same suffix.

    Raises BadInput where there are none, two of one number, or a link to a file of another suffix.
    """
    marks = list(MARK.finditer(path.name))
    if len(marks) != 1:
        right = f"one mark for the number, such as {path.stem}.####{path.suffix}"
        raise BadInput(f"the name of a sequence has {len(marks)} marks", where=path, right=right)
    found: dict[int, Path] = {}
    for match in _matches(path):
        number = int(match[1])
        if number in found:
            what = f"{match[0]} and {found[number].name} have the same number"
            raise BadInput(what, where=path, right="one file for each number")
        found[number] = path.parent / match[0]
        target = Path(os.path.realpath(found[number]))
        if target.suffix.lower() != path.suffix.lower():
            right = f"a link to a {path.suffix} file, or no link"
            raise BadInput(f"the file is a link to {target}", where=found[number], right=right)
    if not found:
        right = f"files such as {MARK.sub(f'{1001:0{len(marks[0][0])}d}', path.name)}"
        raise BadInput("the sequence has no files", where=path, right=right)
    return dict(sorted(found.items()))


def _matches(path: Path) -> list[re.Match[str]]:
    """Match the names in the folder with that of a sequence, which has one mark; the group is the number."""
    before, mark, after = re.split(f"({MARK.pattern})", path.name)
    pattern = re.compile(rf"{re.escape(before)}(-?\d{{{len(mark)},}}){re.escape(after)}")
    names = sorted(file.name for file in path.parent.iterdir()) if path.parent.is_dir() else []
    return [match for match in map(pattern.fullmatch, names) if match]


def _alone(path: Path) -> dict[int, Path]:
    """Return one file as a sequence of one; warns where it is one of several numbered files."""
    sequence = path.with_name(LAST_NUMBER.sub(lambda number: "#" * len(number[0]), path.name))
    count = len(_matches(sequence)) if is_sequence(sequence) else 1
    if count > 1:
        message = f"{path} is one of {count} numbered files, and holds still: {sequence.name} reads all of them"
        warnings.warn(message, stacklevel=2)
    return {0: path}
