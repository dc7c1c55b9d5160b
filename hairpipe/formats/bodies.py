"""A body from a file of any supported format, by its suffix, in the units and axes of the file."""

from pathlib import Path

import numpy as np

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.formats.gltf import SUFFIXES as GLTF
from hairpipe.formats.gltf_bodies import read_body as read_gltf_body
from hairpipe.formats.makehuman import read_skeleton, read_weights
from hairpipe.formats.obj import read_obj
from hairpipe.formats.ply import read_ply_mesh
from hairpipe.plain_file import Absent
from hairpipe.values import Body, Mesh, Skeleton

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


def read_body(
    path: Path,
    *,
    group: str | None = None,
    skeleton: Path | None = None,
    weights: Path | None = None,
    time: float | None = None,
    absent: Absent = "refuse",
) -> Body:
    """Read mesh, skeleton, weights and painted maps; a file without a skeleton gives a body without joints.

    An Alembic file is read at its first sample.

    group              to read: a group or object of an OBJ file, path of a prim of a USD file, name of a node of a glTF
                       file; None for all
    skeleton, weights  files of a MakeHuman rig, for an OBJ file whose vertices they count
    time, absent       of a USD file, see `hairpipe.formats.usd.meshes.read_body`

    Raises BadInput where a file cannot be read, the suffix is unknown, or settings exclude each other.
    """
    if (skeleton is None) != (weights is None):
        raise BadInput(
            "a skeleton requires weights, and weights a skeleton", where="skeleton, weights", right="both or neither"
        )
    if path.suffix.lower() in USD_SUFFIXES:
        if skeleton is not None:
            raise BadInput("USD files contain their skeleton", where="skeleton", right="no skeleton and weights")
        from hairpipe.formats.usd.meshes import read_body as read_usd_body

        return read_usd_body(path, group, time, absent)
    if time is not None:
        raise BadInput("the file has no time codes", where="time_code", right="no time_code, or a USD file")
    if path.suffix.lower() in GLTF:
        if skeleton is not None:
            raise BadInput("glTF files contain their skeleton", where="skeleton", right="no skeleton and weights")
        return work_apart(read_gltf_body, path, group)
    if path.suffix.lower() not in (".obj", ".ply", ".abc"):
        right = ".obj, .ply, .abc, USD, .gltf or .glb"
        raise BadInput(f"bodies are not read from {path.suffix or 'such'} files", where=path, right=right)
    if skeleton is not None and path.suffix.lower() != ".obj":
        right = "no skeleton and weights, or an OBJ file"
        raise BadInput("a MakeHuman rig fits OBJ files", where="skeleton", right=right)
    mesh = read_mesh(path, group)
    if skeleton is None or weights is None:
        nobody = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
        return Body(mesh, nobody, np.zeros((len(mesh.points), 0), np.int32), np.zeros((len(mesh.points), 0)))
    joints = work_apart(read_skeleton, skeleton, mesh.points)
    return Body(mesh, joints, *work_apart(read_weights, weights, joints.names, len(mesh.points)))


def read_mesh(path: Path, group: str | None) -> Mesh:
    """Read the triangles of an OBJ, PLY or Alembic file."""
    if path.suffix.lower() == ".obj":
        return work_apart(read_obj, path, group)
    if path.suffix.lower() == ".ply":
        return work_apart(read_ply_mesh, path, group).mesh
    from hairpipe.formats.alembic_meshes import read_rest

    return work_apart(read_rest, path, group).mesh
