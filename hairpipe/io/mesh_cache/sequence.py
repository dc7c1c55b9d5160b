"""OBJ or PLY files, a numbered sequence or one alone: polygons of the first file, points of each."""

import warnings
from pathlib import Path

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.files import alone, is_sequence, numbered
from hairpipe.io.mesh_cache.moving import Instant, Points, Shape, read_at
from hairpipe.io.mesh_cache.ply_mesh import read_ply_mesh, read_ply_points
from hairpipe.io.obj import read_points, read_polygons


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
        self.first = recall(First, self.files[0], group)
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


class First:
    """Triangles of the first file, and digest of its polygons."""

    def __init__(self, path: Path, group: str | None) -> None:
        read_shape, read_points = READERS[path.suffix.lower()]
        self.files = [path]
        self.shape: Shape = read_shape(path, group)
        self.faces = read_points(path)[1]


def read(path: Path, group: str | None, instant: Instant) -> Shape:
    """Read the mesh of a sequence at an instant."""
    return read_at(Sequence(path, group, instant.fps), instant)


def read_obj_shape(path: Path, group: str | None = None) -> Shape:
    """Read the triangles of an OBJ file, or of a group of it."""
    return Shape(*read_polygons(path, group))


READERS = {".obj": (read_obj_shape, read_points), ".ply": (read_ply_mesh, read_ply_points)}
"""Readers of triangles, and of points with a digest of the polygons, by suffix."""
