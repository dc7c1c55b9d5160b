"""Permitted paths of published files: below the folder of the project, or of a folder that the user names.

Files of the graph itself, and folders from which programs load code, are excluded: the author of a graph may be
unknown, so it must not write outside of its project, nor cause code to be executed. In addition, the node type
declares the suffixes of its files (see `File`).

Third-party files: `file.data = "NAME"` is a path relative to the data folder.

The variable HAIRPIPE_DATA names the folder; its default in a checkout is `shared/data` next to the checkout.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import hairpipe
from hairpipe.engine.file.graph import Graph
from hairpipe.engine.file.read import Location
from hairpipe.engine.node.messages import is_printed
from hairpipe.engine.node.settings import Field
from hairpipe.errors import BadInput

NODES = "nodes"
PACKAGES = {"site-packages", "dist-packages"}
ENVIRONMENTS = ("pyvenv.cfg", "conda-meta")
"""Files that mark a folder as a Python environment."""
OPEN = "/proc/self/fd"
FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW


@dataclass(frozen=True)
class Bounds:
    """Folders below which a graph may publish, and their exceptions.

    store  folder of results
    root   folder that the user allows in addition to the graph's project, or None
    """

    graph: Graph
    store: Path
    root: Path | None = None

    def check(self) -> None:
        """Check the paths of all nodes; BadInput for the first that is not permitted."""
        for node in self.graph.nodes.values():
            if node.publish is not None:
                try:
                    self.folder_of(node.publish)
                except BadInput as fault:
                    shown = f"{self.graph.path}: [{node.name}]: publish: {node.publish}"
                    where = Location(shown, node.name, ["publish"])
                    raise BadInput(fault.what, where=where, right=fault.right) from None

    def folder_of(self, place: Path) -> Path:
        """Find the permitted folder above a resolved path; BadInput if publishing there is not permitted."""
        folders = [self.graph.project, *([self.root.resolve()] if self.root else ())]
        found = next((folder for folder in folders if folder in place.parents), None)
        if found is None:
            what = f"the path leaves {' and '.join(map(str, folders))}"
            raise BadInput(what, where=place, right="a path within, or --publish-root FOLDER")
        kept = self.graph.role(place) or self._kind(place, place.relative_to(found).parts) or python_around(place)
        if kept:
            raise BadInput(f"the path is {kept}", where=place, right="a folder of its own to publish in")
        return found

    def _kind(self, place: Path, names: Sequence[str]) -> str | None:
        """Describe why a path is excluded; None if it is not."""
        if place.is_relative_to(self.store.resolve()):
            return "in the store"
        if any(name.startswith(".") for name in names):
            return "hidden"
        if any(name.startswith("-") for name in names):
            return "a name that looks like an option of a command"
        if not all(map(is_printed, "".join(names))):
            return "a name with invisible characters"
        return "in a folder of node types" if NODES in map(str.casefold, names) else None


def python_around(place: Path) -> str | None:
    """Describe the folder of Python packages above a path; None if there is none.

    Names are compared without case, as some file systems do.
    """
    for folder in place.parents:
        if folder.name.casefold() in PACKAGES:
            return f"in the packages of Python: {folder}"
        mark = next((name for name in ENVIRONMENTS if os.path.lexists(folder / name)), None)
        if mark:
            return f"in an environment of Python: {folder} holds {mark}"
    return None


def check_way(place: Path) -> None:
    """Refuse a path with a link, which was created after the graph was read: its links were resolved then."""
    if place.parent.resolve() != place.parent or place.is_symlink():
        right = "a folder without links, or --publish-root FOLDER"
        raise BadInput("the path contains a link", where=place, right=right)


@contextmanager
def entered(root: Path, folder: Path) -> Iterator[Path]:
    """Open a folder from a root down, and create missing folders, without following links.

    Yields a path that remains valid if the folder is replaced, where the system has such paths; else the path of the
    folder. OSError if a file or a link is in its place.
    """
    root.mkdir(parents=True, exist_ok=True)
    handle = os.open(root, FOLDER)
    try:
        for name in folder.relative_to(root).parts:
            with suppress(FileExistsError):
                os.mkdir(name, dir_fd=handle)
            above = handle
            handle = os.open(name, FOLDER, dir_fd=handle)
            os.close(above)
        open_folder = Path(OPEN, str(handle))
        yield open_folder if open_folder.is_dir() else folder
    finally:
        os.close(handle)


VARIABLE = "HAIRPIPE_DATA"
KEY = "data"
"""Key of a table that replaces the path of a file."""
RIGHT = f"a file below the folder that {VARIABLE} names; `hairpipe data check` lists those that shipped graphs read"
Place = Callable[[Sequence[str]], str]


def data_folder() -> Path | None:
    """Return the data folder, which may not exist; None outside of a checkout if the variable is not set."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given).absolute()
    checkout = Path(hairpipe.__file__).resolve().parents[1]
    return checkout.parent / "shared" / "data" if (checkout / "pyproject.toml").is_file() else None


def known_folder() -> Path:
    """Return the data folder; BadInput if it is not known."""
    folder = data_folder()
    if folder is None:
        raise BadInput(f"{VARIABLE} is not set", right="the folder of third-party data")
    return folder


def located(
    fields: Iterable[Field], given: dict[str, Any], place: Place, above: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return settings in which each `{ data = NAME }` in place of a file is replaced by the path; pure.

    place  returns the line of a setting

    BadInput if the data folder is not known, or the name is outside of it.
    """
    changed = dict(given)
    for field in fields:
        value = given.get(field.name)
        names = (*above, field.name)
        if isinstance(value, dict) and field.group:
            changed[field.name] = located(field.group, value, place, names)
        elif isinstance(value, dict) and field.base is Path and value.keys() == {KEY}:
            changed[field.name] = path_of(value[KEY], ".".join(names), place(names))
    return changed


def path_of(name: Any, setting: str, where: str) -> str:
    """Return the path of a file in the data folder; BadInput as above."""
    inside = isinstance(name, str) and not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts
    if not inside:
        raise BadInput(f"{setting}.{KEY} = {str(name)[:200]!r} is outside of the data folder", where=where, right=RIGHT)
    try:
        return str(known_folder() / name)
    except BadInput as fault:
        raise BadInput(f"{setting}.{KEY} = {name[:200]!r}: {fault.what}", where=where, right=RIGHT) from None


def is_data(file: str) -> bool:
    """Whether the path of a setting is in the data folder."""
    folder = data_folder()
    return folder is not None and Path(file).is_relative_to(folder)
