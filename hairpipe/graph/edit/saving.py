"""Writes the text of a graph file; its permissions, owner and links are kept."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hairpipe.graph.edit.inline_table import literal_of
from hairpipe.graph.edit.verbs import with_value
from hairpipe.graph.file.read import read_graph_text
from hairpipe.graph.store.atomic import overwrite, write_text

BOM = "\ufeff"


def save_settings(path: Path, settings: Mapping[str, Any]) -> None:
    """Write settings into a graph file; BadInput as for `with_settings`."""
    save_text(path, with_settings(read_graph_text(path).text, settings))


def save_text(path: Path, text: str) -> None:
    """Write a graph file, which may be new; OSError for a file that cannot be written."""
    target = path.resolve()
    found = target.stat() if target.exists() else None
    mark = BOM if found and target.read_bytes().startswith(BOM.encode()) else ""
    if found and (found.st_nlink > 1 or found.st_uid != os.geteuid()):  # a new file would have one name, and be ours
        overwrite(target, (mark + text).encode("utf-8"))
    else:
        write_text(target, mark + text)


def with_settings(text: str, settings: Mapping[str, Any]) -> str:
    """Return the text of a graph file with settings changed, by `node.setting` or `node.group.setting`.

    BadInput if a setting cannot be set, or if the layout of the text does not permit the change.
    """
    for target, value in settings.items():
        text = with_value(text, target, literal_of(value))
    return text
