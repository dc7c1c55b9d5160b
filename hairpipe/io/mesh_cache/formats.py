"""An animated mesh at one instant, by the suffix of its file."""

from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.files import ALEMBIC, NUMBERED, SUFFIXES, USD
from hairpipe.io.mesh_cache.moving import Instant, Shape, read_at
from hairpipe.io.usd.apart import work_apart


def read_moving(path: Path, group: str | None, instant: Instant) -> Shape:
    """Return the triangles of an animated mesh at an instant, with velocities; USD in metres with Y up.

    group  path or pattern of prims or objects to read, group of an OBJ file; None for all

    Raises BadInput where a file cannot be read, or its polygons change.
    """
    suffix = path.suffix.lower()
    if suffix in USD:
        from hairpipe.io.usd import moving_meshes

        return work_apart(moving_meshes.read, path, group, instant)
    if suffix == ALEMBIC:
        from hairpipe.io.mesh_cache import alembic_meshes

        return work_apart(alembic_meshes.read, path, group, instant)
    if suffix in NUMBERED:
        from hairpipe.io.mesh_cache.obj_sequence import ObjSequence

        return read_at(ObjSequence(path, group, instant.fps), instant)
    raise BadInput(f"meshes are not read from {suffix or 'such'} files", where=path, right=", ".join(SUFFIXES))
