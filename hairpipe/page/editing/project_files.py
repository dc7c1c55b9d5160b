"""Files of the project of a graph, for the page: folders are listed, and images shown; nothing outside is read."""

import os
from itertools import islice
from pathlib import Path
from typing import Any

from hairpipe.api.shot import Graph, project_of
from hairpipe.errors import BadInput
from hairpipe.page.values import suffix_of

MOST_ENTRIES = 2000
MOST_BYTES = 1 << 24
"""Largest number of listed files of a folder, and size of a shown image."""


def read_path(graph: Graph, given: str) -> dict[str, Any] | tuple[bytes, str]:
    """List a folder of the project, folders first, or read an image in it, with its suffix.

    given  path relative to the folder of the graph, as in its settings

    BadInput for a hidden path, one outside of the project, and any other file.
    """
    project = project_of(graph.path).resolve()
    try:
        path = graph.file(given).resolve()
        if not any(name.startswith(".") for name in path.relative_to(project).parts):
            if path.is_dir():
                return listed(path, project, graph.path.parent.resolve())
            suffix = suffix_of(path) if path.is_file() else None
            if suffix not in (None, ".svg") and path.stat().st_size <= MOST_BYTES:
                return path.read_bytes(), str(suffix)
    except (OSError, ValueError):  # outside, unreadable, or not a path
        pass
    raise BadInput("not a folder or image of the project", where=given[:80], right=f"a path below {project}")


def listed(folder: Path, project: Path, home: Path) -> dict[str, Any]:
    """List a folder, and the one above it, by paths relative to `home`; links are left out."""
    found = sorted(folder.iterdir(), key=lambda path: (not path.is_dir(), path.name.casefold()))
    named = (path for path in found if not path.name.startswith(".") and path.name.isprintable())
    shown = [path for path in islice(named, MOST_ENTRIES) if path.resolve() == path]
    entries = [
        {"name": path.name, "path": os.path.relpath(path, home), "folder": path.is_dir(), "bytes": path.stat().st_size}
        for path in [*([folder / ".."] if folder != project else []), *shown]
    ]
    return {"folder": os.path.relpath(folder, project), "entries": entries}
