"""Writes settings into the text of a graph file; all other characters are unchanged."""

import os
import re
import tomllib
from collections.abc import Mapping, MutableMapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import InlineTable

from hairpipe.errors import BadInput
from hairpipe.graph.file.overrides import put
from hairpipe.graph.file.read import read_graph_text
from hairpipe.graph.store.atomic import overwrite, write_text

BOM = "\ufeff"
TABLE = re.compile(r"\s*\[([^\[\]]+)\]\s*(?:#.*)?")


def save_settings(path: Path, settings: Mapping[str, Any]) -> None:
    """Write settings into a graph file, and keep its permissions, owner and links; BadInput as for `with_settings`."""
    mark = BOM if path.read_bytes().startswith(BOM.encode()) else ""
    text = mark + with_settings(read_graph_text(path).text, settings)
    target = path.resolve()
    found = target.stat()
    if found.st_nlink > 1 or found.st_uid != os.geteuid():  # a new file would have one name, and be ours
        overwrite(target, text.encode("utf-8"))
    else:
        write_text(target, text)


def with_settings(text: str, settings: Mapping[str, Any]) -> str:
    """Return the text of a graph file with settings changed, by `node.setting` or `node.group.setting`.

    A new setting is added as the last line of its table. BadInput if a setting cannot be set, or if the layout of the
    text does not permit the change.
    """
    for target, value in settings.items():
        wanted = deepcopy(tomllib.loads(text.replace("\r\n", "\n")))
        put(wanted, target, value)
        try:
            text = changed(text, target.split("."), value)
            written = tomllib.loads(text.replace("\r\n", "\n"))
        except (TOMLKitError, ValueError, TypeError, StopIteration):
            written = None
        if written != wanted:
            what = f"{target} = {tomlkit.item(value).as_string()} cannot be written without a change of the layout"
            raise BadInput(what, right="a line written by hand")
    return text


def changed(text: str, names: Sequence[str], value: Any) -> str:
    """Return the text with one value changed or added."""
    document = tomlkit.parse(text)
    table: Any = document
    for name in names[:-1]:
        table = table.get(name, {})
    if names[-1] in table or isinstance(table, InlineTable):
        assert isinstance(table, MutableMapping)
        table[names[-1]] = value
        return document.as_string()
    return with_line(text, names, value)


def with_line(text: str, names: Sequence[str], value: Any) -> str:
    """Return the text with a value added as the last line of the innermost table in it."""
    lines = text.splitlines(keepends=True)
    headers = {number: match[1].strip() for number, line in enumerate(lines) if (match := TABLE.fullmatch(line))}
    depth = next(depth for depth in range(len(names) - 1, 0, -1) if ".".join(names[:depth]) in headers.values())
    begin = next(number for number, name in headers.items() if name == ".".join(names[:depth]))
    end = min((number for number in headers if number > begin), default=len(lines))
    last = max(number for number in range(begin, end) if lines[number].partition("#")[0].strip())
    newline = "\r\n" if lines[begin].endswith("\r\n") else "\n"
    lines[last] = lines[last].rstrip("\r\n") + newline
    line = f"{'.'.join(names[depth:])} = {tomlkit.item(value).as_string()}{newline}"
    return "".join([*lines[: last + 1], line, *lines[last + 1 :]])
