"""An animated mesh or skeleton at one instant, by the suffix of its file.

OBJ or PLY files, a numbered sequence or one alone: polygons of the first file, points of each.
"""

import warnings
from functools import lru_cache
from pathlib import Path

import numpy as np

from hairpipe.apart import recall, work_apart
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import (
    ALEMBIC,
    GLTF,
    NUMBERED,
    SUFFIXES,
    USD,
    Instant,
    Points,
    Shape,
    alone,
    is_sequence,
    list_files,
    numbered,
    read_at,
)
from hairpipe.formats.joint_motion import JointMotion
from hairpipe.formats.obj import read_points, read_polygons
from hairpipe.formats.ply import read_ply_mesh, read_ply_points
from hairpipe.plain_file import Absent, stamp_of


class Sequence:
    """Samples of a sequence, see `hairpipe.formats.animated_meshes.Source`; the number of a file is its time code.

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


BVH = ".bvh"


def read_moving(path: Path, group: str | None, clip: str | None, instant: Instant, absent: Absent = "refuse") -> Shape:
    """Return the triangles of an animated mesh at an instant, with velocities; USD and glTF in metres with Y up.

    group   path or pattern of prims, objects or nodes to read, group of an OBJ file; None for all
    clip    name or pattern of animations of a glTF file; None for the first
    absent  whether absent files of a stage are refused, or warned of

    Raises BadInput where a file cannot be read, or its polygons change.
    """
    suffix = path.suffix.lower()
    _check_clip(suffix, clip)
    if suffix in GLTF:
        from hairpipe.formats.gltf_meshes import read_moving as read_clip

        return work_apart(read_clip, path, group, clip, instant)
    if suffix in USD:
        from hairpipe.formats.usd import moving_meshes

        return work_apart(moving_meshes.read, path, group, instant, absent)
    if suffix == ALEMBIC:
        from hairpipe.formats import alembic_meshes

        return work_apart(alembic_meshes.read, path, group, instant)
    if suffix in NUMBERED:
        from hairpipe.formats import animation_files as sequence

        return work_apart(sequence.read, path, group, instant)
    raise BadInput(f"meshes are not read from {suffix or 'such'} files", where=path, right=", ".join(SUFFIXES))


def recall_joints(
    path: Path, group: str | None, clip: str | None, fps: float, absent: Absent = "refuse"
) -> JointMotion | None:
    """Return the motion of the joints of a glTF or USD file, read once per process while its files are unchanged.

    None for a BVH file, which is a clip without a body.

    group, clip, absent  as of `read_moving`; fps  of the shot [1/s]
    """
    if path.suffix.lower() == BVH:
        if clip or group:
            raise BadInput("a BVH file has one clip", where=path, right="no clip and no group")
        return None
    _check_clip(path.suffix.lower(), clip)
    return _read_joints(
        path, group, clip, fps, absent, tuple(stamp_of(str(file)) for file in list_files(path).values())
    )


@lru_cache(maxsize=8)
def _read_joints(
    path: Path, group: str | None, clip: str | None, fps: float, absent: Absent, _: tuple[object, ...]
) -> JointMotion:
    if path.suffix.lower() in GLTF:
        from hairpipe.formats.gltf_bodies import read_joints

        return work_apart(read_joints, path, group, clip, fps)
    from hairpipe.formats.usd import skeleton as joints_of_skeletons

    return work_apart(joints_of_skeletons.read, path, group, absent)


def _check_clip(suffix: str, clip: str | None) -> None:
    if clip is not None and suffix not in GLTF:
        raise BadInput("the format has no clips", where="clip", right="no clip, or a file .gltf or .glb")
