"""Settings as TOML: the whole tables of a graph file that a choice changes, to replace those of the file."""

import json
import re
from collections.abc import Iterator
from typing import Any

from hairpipe.graph.file.overrides import Tables

BARE = re.compile(r"[A-Za-z0-9_-]+")


def changed_tables(before: Tables, after: Tables) -> Tables:
    """Return the tables of nodes that have changed."""
    return {name: table for name, table in after.items() if isinstance(table, dict) and table != before.get(name)}


def write_toml(tables: Tables, comment: str) -> str:
    """Write tables of nodes as TOML, below a comment."""
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    for name, table in tables.items():
        lines += ["", *table_lines([name], table)]
    return "\n".join(lines) + "\n"


def table_lines(path: list[str], table: Tables) -> Iterator[str]:
    """Write a table: its values first, then the tables in it."""
    yield f"[{'.'.join(map(key, path))}]"
    for name, value in table.items():
        if not is_table(name, value, path):
            yield f"{key(name)} = {inline(value)}"
    for name, value in table.items():
        if is_table(name, value, path):
            yield from table_lines([*path, name], value)


def is_table(name: str, value: Any, path: list[str]) -> bool:
    """Whether a value gets a header of its own; edges stay on one line."""
    return isinstance(value, dict) and not (name == "in" and len(path) == 1)


def inline(value: Any) -> str:
    """Write a value of TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key(name)} = {inline(item)}" for name, item in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(inline, value))}]"
    if isinstance(value, str):
        return quoted(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)


def key(name: str) -> str:
    """Write a name, quoted where it has to be."""
    return name if BARE.fullmatch(name) else quoted(name)


def quoted(text: str) -> str:
    """Write a text: as in JSON, but TOML knows no surrogate pairs and wants DEL escaped."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
