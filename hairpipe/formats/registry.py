"""Files of other programs: what a file of each suffix can hold, the functions that read it, and its parts.

Readers, nodes and messages take suffixes from this table alone.
"""

from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, NamedTuple

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.formats import gltf
from hairpipe.formats.animated_meshes import Instant, Polygons, is_sequence, numbered
from hairpipe.formats.makehuman import read_skeleton, read_weights
from hairpipe.formats.rigging import JointMotion, body_of
from hairpipe.plain_file import Absent, stamp_of, with_folders
from hairpipe.values import Body, Mesh
from hairpipe.values.groom import Curves

Content = Literal["body", "meshes", "motion", "strands"]


class Format(NamedTuple):
    """Functions that read a format in a child process, by what its files can hold; "" where they hold none of it."""

    suffixes: tuple[str, ...]
    body: str = ""
    meshes: str = ""
    motion: str = ""
    strands: str = ""


USD = Format(
    (".usd", ".usda", ".usdc", ".usdz"),
    body="hairpipe.formats.usd.meshes.read_body",
    meshes="hairpipe.formats.usd.meshes.read_moving",
    motion="hairpipe.formats.usd.meshes.read_joints",
    strands="hairpipe.formats.usd.curves.read_curves",
)
"""Stages are composed of other files, have time codes, and contain skeletons, as glTF files do."""
GLTF = Format(
    gltf.SUFFIXES,
    body="hairpipe.formats.gltf.read_body",
    meshes="hairpipe.formats.gltf.read_moving",
    motion="hairpipe.formats.gltf.read_joints",
)
"""Files with several animations, by name."""
BVH = Format((".bvh",), motion="hairpipe.formats.bvh.recall_bvh")
FORMATS = (
    USD,
    GLTF,
    Format(
        (".abc",),
        body="hairpipe.formats.alembic.read",
        meshes="hairpipe.formats.alembic.read",
        strands="hairpipe.formats.alembic.read_alembic",
    ),
    Format((".hair",), strands="hairpipe.formats.yuksel.read_hair"),
    Format((".data", ".bin"), strands="hairpipe.formats.polylines.read_records"),
    Format(
        (".ply",),
        body="hairpipe.formats.ply.read_ply_mesh",
        meshes="hairpipe.formats.animated_meshes.read_sequence",
        strands="hairpipe.formats.polylines.read_ply_strands",
    ),
    Format(
        (".obj",),
        body="hairpipe.formats.obj.read_polygons",
        meshes="hairpipe.formats.animated_meshes.read_sequence",
        strands="hairpipe.formats.polylines.read_obj_strands",
    ),
    Format((".tfx",), strands="hairpipe.formats.tfx.read_tfx"),
    BVH,
)


def suffixes_of(content: Content) -> tuple[str, ...]:
    """Return the suffixes of files that can hold a body, animated meshes, a motion or strands."""
    return tuple(suffix for form in FORMATS if getattr(form, content) for suffix in form.suffixes)


def _format_of(path: Path, content: Content, noun: str) -> Format:
    suffix = path.suffix.lower()
    found = next((form for form in FORMATS if suffix in form.suffixes and getattr(form, content)), None)
    if found is None:
        *others, last = suffixes_of(content)
        right = f"{', '.join(others)} or {last}"
        raise BadInput(f"{noun} not read from {suffix or 'such'} files", where=path, right=right)
    return found


def _read(function: str, path: Path, *arguments: Any) -> Any:
    """Return what a function, given by its module and name, reads of a file in a child process."""
    module, _, name = function.rpartition(".")
    return work_apart(getattr(import_module(module), name), path, *arguments)


def read_body(
    path: Path,
    group: str | None = None,
    *,
    skeleton: Path | None = None,
    weights: Path | None = None,
    time: float | None = None,
    absent: Absent = "refuse",
) -> Body:
    """Read mesh, skeleton, weights and painted maps; a file without a skeleton gives a body without joints.

    An Alembic file is read at its first sample. A stage and a glTF file are in metres, others as they are.

    group              to read: a group or object of an OBJ file, path of a prim of a USD file, name of a node of a glTF
                       file; None for all
    skeleton, weights  files of a MakeHuman rig, for an OBJ file whose vertices they count
    time, absent       of a USD file, see `usd/meshes.py`

    Raises BadInput where a file cannot be read, the suffix is unknown, or settings exclude each other.
    """
    if (skeleton is None) != (weights is None):
        what = "a skeleton requires weights, and weights a skeleton"
        raise BadInput(what, where="skeleton, weights", right="both or neither")
    form = _format_of(path, "body", "bodies are")
    if time is not None and form is not USD:
        raise BadInput("the file has no time codes", where="time_code", right="no time_code, or a USD file")
    if skeleton is not None and form in (USD, GLTF):
        what = f"{'USD' if form is USD else 'glTF'} files contain their skeleton"
        raise BadInput(what, where="skeleton", right="no skeleton and weights")
    if skeleton is not None and ".obj" not in form.suffixes:
        right = "no skeleton and weights, or an OBJ file"
        raise BadInput("a MakeHuman rig fits OBJ files", where="skeleton", right=right)
    found = _read(form.body, path, group, *((time, absent) if form is USD else ()))
    if isinstance(found, Body):
        return found
    mesh: Mesh = found.mesh
    if skeleton is None or weights is None:
        return body_of(mesh)
    joints = work_apart(read_skeleton, skeleton, mesh.points)
    return Body(mesh, joints, *work_apart(read_weights, weights, joints.names, len(mesh.points)))


def read_moving(
    path: Path, group: str | None, clip: str | None, instant: Instant, absent: Absent = "refuse"
) -> Polygons:
    """Return the triangles of an animated mesh at an instant, with velocities; USD and glTF in metres with Y up.

    group   path or pattern of prims, objects or nodes to read, group of an OBJ file; None for all
    clip    name or pattern of animations of a glTF file; None for the first
    absent  whether absent files of a stage are refused, or warned of

    Raises BadInput where a file cannot be read, or its polygons change.
    """
    form = _format_of(path, "meshes", "meshes are")
    _check_clip(form, clip)
    options = (clip, instant) if form is GLTF else (instant, absent) if form is USD else (instant,)
    return _read(form.meshes, path, group, *options)


def recall_joints(
    path: Path, group: str | None, clip: str | None, fps: float, absent: Absent = "refuse"
) -> JointMotion | None:
    """Return the motion of the joints of a glTF or USD file, read once per process while its files are unchanged.

    None for a BVH file, which is a clip without a body.

    group, clip, absent  as of `read_moving`; fps  of the shot [1/s]
    """
    form = _format_of(path, "motion", "motion is")
    if form is BVH:
        if clip or group:
            raise BadInput("a BVH file has one clip", where=path, right="no clip and no group")
        return None
    _check_clip(form, clip)
    options = (clip, fps) if form is GLTF else (absent,)
    stamps = tuple(stamp_of(str(file)) for file in list_files(path).values())
    return _recall_joints(form.motion, path, (group, *options), stamps)


@lru_cache(maxsize=8)
def _recall_joints(function: str, path: Path, options: tuple[Any, ...], _: tuple[object, ...]) -> JointMotion:
    return _read(function, path, *options)


def _check_clip(form: Format, clip: str | None) -> None:
    if clip is not None and form is not GLTF:
        right = f"no clip, or a file {' or '.join(GLTF.suffixes)}"
        raise BadInput("the format has no clips", where="clip", right=right)


def read_strands(
    path: Path,
    unit: float,
    up: Literal["y", "z"],
    time: float | None,
    guides: bool = False,
    absent: Absent = "refuse",
) -> Curves:
    """Return the strands of a file, in metres with Y up.

    unit, up  unit [m] and axis of a file that states neither
    time      time code of a file with samples
    guides    whether curves of purpose guide are read in any case
    absent    whether absent files of a stage are refused, or warned of

    Raises BadInput, with the place, where the file cannot be read.
    """
    form = _format_of(path, "strands", "hair is")
    return _read(form.strands, path, *((None, time, guides, absent) if form is USD else (unit, up)))


def list_files(path: Path) -> dict[str, Path]:
    """Return the files that are read for a path, by their names; one alone has none.

    Those of a sequence such as `mesh.####.obj` are named by their numbers, those of a stage by relative paths.

    Raises BadInput where there are none, or where a stage cannot be read.
    """
    if is_sequence(path):
        return {str(number): file for number, file in numbered(path).items()}
    return list_parts(path)


def list_parts(path: Path) -> dict[str, Path]:
    """Return the files of a mesh, hair or motion that is not a sequence, as of `list_files`."""
    is_stage = path.suffix.lower() in USD.suffixes and path.is_file()
    return _list_layers(path) if is_stage else gltf.list_files(path)


_known: dict[Path, tuple[dict[str, tuple[int, ...]], dict[str, Path]]] = {}
"""Files of stages, with the stamps of these and of their folders: as long as all are unchanged, so is the list.

Files that do not exist have stamps, too: the stage is composed of them as soon as they do.
"""


def _list_layers(path: Path) -> dict[str, Path]:
    """Return the existing files that a stage is composed of, and those of its value clips, by relative paths."""
    known = _known.get(path)
    if known is None or any(stamp_of(file) != stamp for file, stamp in known[0].items()):
        from hairpipe.formats.usd.stage import list_files as composed

        found = work_apart(composed, path)
        stamps = {str(place): stamp_of(str(place)) for place in with_folders(found)}
        _known[path] = known = stamps, gltf.named(path, [file for file in found if file.exists()])
    return known[1]
