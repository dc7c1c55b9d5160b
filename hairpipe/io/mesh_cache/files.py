"""Files of an animated mesh: a numbered sequence, the layers and value clips of a stage, or buffers of glTF."""

import os
import re
import warnings
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.io.gltf.document import SUFFIXES as GLTF
from hairpipe.io.gltf.document import list_files as list_buffers
from hairpipe.io.gltf.document import named
from hairpipe.plain_file import stamp_of

USD = (".usd", ".usda", ".usdc", ".usdz")
NUMBERED = (".obj", ".ply")
ALEMBIC = ".abc"
SUFFIXES = (*USD, ALEMBIC, *GLTF, *NUMBERED)
MARK = re.compile(r"#+")
LAST_NUMBER = re.compile(r"\d+(?=\.\w+$)")
Stamps = dict[str, tuple[int, ...]]

_known: dict[Path, tuple[Stamps, dict[str, Path]]] = {}
"""Files of stages, with the stamps of these and of their folders: as long as all are unchanged, so is the list.

Files that do not exist have stamps, too: the stage is composed of them as soon as they do.
"""


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
    return list_layers(path) if path.suffix.lower() in USD and path.is_file() else list_buffers(path)


def is_sequence(path: Path) -> bool:
    """Whether a path is that of a numbered sequence; one without a mark for the number is that of a still mesh."""
    return path.suffix.lower() in NUMBERED and MARK.search(path.name) is not None


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
    for match in matches(path):
        number = int(match[1])
        if number in found:
            what = f"{match[0]} and {found[number].name} have the same number"
            raise BadInput(what, where=path, right="one file for each number")
        found[number] = path.parent / match[0]
        target = Path(os.path.realpath(found[number]))
        if target.suffix.lower() != path.suffix.lower():
            what = f"the file is a link to {target}"
            raise BadInput(what, where=found[number], right=f"a link to a {path.suffix} file, or no link")
    if not found:
        right = f"files such as {MARK.sub(f'{1001:0{len(marks[0][0])}d}', path.name)}"
        raise BadInput("the sequence has no files", where=path, right=right)
    return dict(sorted(found.items()))


def matches(path: Path) -> list[re.Match[str]]:
    """Match the names in the folder with that of a sequence, which has one mark; the group is the number."""
    before, mark, after = re.split(f"({MARK.pattern})", path.name)
    pattern = re.compile(rf"{re.escape(before)}(-?\d{{{len(mark)},}}){re.escape(after)}")
    names = sorted(file.name for file in path.parent.iterdir()) if path.parent.is_dir() else []
    return [match for match in map(pattern.fullmatch, names) if match]


def alone(path: Path) -> dict[int, Path]:
    """Return one file as a sequence of one; warns where it is one of several numbered files."""
    sequence = path.with_name(LAST_NUMBER.sub(lambda number: "#" * len(number[0]), path.name))
    count = len(matches(sequence)) if is_sequence(sequence) else 1
    if count > 1:
        message = f"{path} is one of {count} numbered files, and holds still: {sequence.name} reads all of them"
        warnings.warn(message, stacklevel=2)
    return {0: path}


def list_layers(path: Path) -> dict[str, Path]:
    """Return the existing files that a stage is composed of, and those of its value clips, by relative paths."""
    known = _known.get(path)
    if known is None or any(stamp_of(file) != stamp for file, stamp in known[0].items()):
        from hairpipe.apart import work_apart
        from hairpipe.io.usd.layer_files import list_files as composed
        from hairpipe.io.usd.layer_files import with_folders

        found = work_apart(composed, path)
        stamps = {str(place): stamp_of(str(place)) for place in with_folders(found)}
        _known[path] = known = stamps, named(path, [file for file in found if file.exists()])
    return known[1]
