"""Where a graph may publish: below the folder of its project, or one that the user names, and never over its own files
or where programs look for code.

A graph may come from anybody, so it must not choose paths outside of its project, nor cause code to be executed.
Published files have a suffix of data, which their node type declares (see `File`); the rules for folders apply in
addition.
"""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.node.messages import is_printed

NODES = "nodes"
PACKAGES = {"site-packages", "dist-packages"}
ENVIRONMENTS = ("pyvenv.cfg", "conda-meta")
"""What a folder holds that is an environment of Python."""
OPEN = "/proc/self/fd"
FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW


@dataclass(frozen=True)
class Bounds:
    """Folders below which a graph may publish, and the exceptions there.

    store  folder of results
    root   folder that the user allows in addition to the graph's project, or None
    """

    graph: Graph
    store: Path
    root: Path | None = None

    def check(self) -> None:
        """Refuse a graph that would publish elsewhere; BadInput for the first node that does."""
        for node in self.graph.nodes.values():
            if node.publish is not None:
                try:
                    self.folder_of(node.publish)
                except BadInput as fault:
                    where = f"{self.graph.path}: [{node.name}]: publish: {node.publish}"
                    raise BadInput(fault.what, where=where, right=fault.right) from None

    def folder_of(self, place: Path) -> Path:
        """Find the folder below which a place lies, its links followed; BadInput where nothing may be published."""
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
        """Describe a path that no graph may publish to; None for others."""
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
    """Describe the folder of Python that a path lies in; None for a path in none.

    Some file systems take names that differ in case for the same.
    """
    for folder in place.parents:
        if folder.name.casefold() in PACKAGES:
            return f"in the packages of Python: {folder}"
        mark = next((name for name in ENVIRONMENTS if os.path.lexists(folder / name)), None)
        if mark:
            return f"in an environment of Python: {folder} holds {mark}"
    return None


def check_way(place: Path) -> None:
    """Refuse a path through a link: links were resolved when the graph was read, so this one is new."""
    if place.parent.resolve() != place.parent or place.is_symlink():
        raise BadInput(
            "the path contains a link", where=place, right="a folder without links, or --publish-root FOLDER"
        )


@contextmanager
def entered(root: Path, folder: Path) -> Iterator[Path]:
    """Open a folder step by step from a root, and make what is missing; no step follows a link.

    Yields a path of the open folder that stays valid if it is replaced, where the system has such paths; else the
    folder's own. OSError where something else is in its place.
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
