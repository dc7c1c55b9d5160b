"""An animated mesh or skeleton at one instant, by the suffix of its file."""

from functools import lru_cache
from pathlib import Path

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.files import ALEMBIC, GLTF, NUMBERED, SUFFIXES, USD, list_files
from hairpipe.io.mesh_cache.joint_motion import JointMotion
from hairpipe.io.mesh_cache.moving import Instant, Shape
from hairpipe.plain_file import Absent, stamp_of

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
        from hairpipe.io.gltf.skinned_pieces import read_moving as read_clip

        return work_apart(read_clip, path, group, clip, instant)
    if suffix in USD:
        from hairpipe.io.usd.meshes import moving_meshes

        return work_apart(moving_meshes.read, path, group, instant, absent)
    if suffix == ALEMBIC:
        from hairpipe.io.mesh_cache import alembic_meshes

        return work_apart(alembic_meshes.read, path, group, instant)
    if suffix in NUMBERED:
        from hairpipe.io.mesh_cache import sequence

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
        from hairpipe.io.gltf.joints_of_skins import read_joints

        return work_apart(read_joints, path, group, clip, fps)
    from hairpipe.io.usd.meshes import joints_of_skeletons

    return work_apart(joints_of_skeletons.read, path, group, absent)


def _check_clip(suffix: str, clip: str | None) -> None:
    if clip is not None and suffix not in GLTF:
        raise BadInput("the format has no clips", where="clip", right="no clip, or a file .gltf or .glb")
