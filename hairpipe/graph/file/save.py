"""Writes settings into a graph file: only these values change; comments, order and layout stay."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from hairpipe.errors import BadInput
from hairpipe.graph.store.atomic import write_text


def save_settings(path: Path, settings: Mapping[str, Any]) -> None:
    """Write settings, by `node.setting` or `node.group.setting`, into a graph file.

    BadInput where the file cannot be read or a target has no place in it, OSError where it cannot be written.
    """
    try:
        document = tomlkit.parse(path.read_bytes().decode())
    except (OSError, UnicodeDecodeError, TOMLKitError) as error:
        raise BadInput(f"cannot be read: {error}", where=path, right="a graph file") from None
    for target, value in settings.items():
        put_value(document, target.split("."), value, path)
    write_text(path, tomlkit.dumps(document), path.parent)


def put_value(table: Any, names: list[str], value: Any, path: Path) -> None:
    """Set a value in a table, in place; groups on the way that are not there are made."""
    *groups, last = names
    for name in groups:
        if name not in table:
            table[name] = tomlkit.inline_table()
        table = table[name]
        if not isinstance(table, dict):
            raise BadInput(f"'{name}' in '{'.'.join(names)}' is no group", where=path, right="node.setting")
    table[last] = value
