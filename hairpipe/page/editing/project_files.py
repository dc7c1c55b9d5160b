"""Files of the project of a graph, for the page: folders are listed, and images shown; nothing outside is read."""

import os
from pathlib import Path
from typing import Any

from hairpipe.api.shot import Graph
from hairpipe.errors import BadInput
from hairpipe.page.values import suffix_of

MOST_ENTRIES = 2000
MOST_BYTES = 1 << 24
"""Largest number of listed files of a folder, and size of a shown image."""


def within(graph: Graph, given: str) -> Path:
    """Return the resolved path of a file or folder; BadInput for one that is hidden, or outside of the project.

    given  path relative to the folder of the graph, as in its settings
    """
    project = graph.project.resolve()
    try:
        path = graph.file(given).resolve()
        if not any(name.startswith(".") for name in path.relative_to(project).parts):
            return path
    except (OSError, ValueError):  # outside, or not a path
        pass
    raise BadInput("not a file of the project", where=given[:80], right=f"a path below {project}")


def listed_folder(graph: Graph, given: str) -> dict[str, Any]:
    """List a folder of the project, folders first; BadInput as `within`, and for a folder that cannot be read."""
    folder = within(graph, given)
    home = graph.path.parent.resolve()
    entries = []
    try:
        found = sorted(folder.iterdir(), key=lambda path: (not path.is_dir(), path.name.casefold()))[:MOST_ENTRIES]
        for path in [*([folder / ".."] if folder != graph.project.resolve() else []), *found]:
            if path.name == ".." or (not path.name.startswith(".") and path.resolve() == path):
                entry = {"name": path.name, "path": os.path.relpath(path, home), "folder": path.is_dir()}
                entries.append(entry | {"bytes": path.stat().st_size})
    except OSError as error:
        raise BadInput(f"cannot be read: {error.strerror}", where=given[:80]) from None
    return {"folder": os.path.relpath(folder, graph.project.resolve()), "entries": entries}


def read_image(graph: Graph, given: str) -> tuple[bytes, str]:
    """Read an image of the project, and its suffix; BadInput as `within`, and for another or a large file."""
    path = within(graph, given)
    suffix = suffix_of(path)
    if suffix in (None, ".svg") or not path.is_file() or path.stat().st_size > MOST_BYTES:
        raise BadInput("not an image", where=given[:80])
    return path.read_bytes(), str(suffix)
