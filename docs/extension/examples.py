"""Examples of node types: tables of the shipped graphs."""

import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from hairpipe.app.api.node_types import NodeType, fields_of

HOME = Path(__file__).resolve().parents[2]
COMMENTS_AT_END = re.compile(r"(?:\n#.*|\n\s*)+$")
"""What belongs to the next table."""
LONGEST = 25
"""Lines of an example, where a shorter one can be had."""


@cache
def tables() -> dict[str, list[tuple[str, str]]]:
    """Return the tables of all shipped graphs by node type, the simple graphs first: the graph's name, and the text."""
    found: dict[str, list[tuple[str, str]]] = {}
    paths = sorted((HOME / "graphs").rglob("*.toml"), key=lambda path: ("experiments" in path.parts, len(path.parts)))
    for path in paths:
        for node_type, text in tables_in(path.read_text(encoding="utf-8")):
            found.setdefault(node_type, []).append((path.relative_to(HOME).as_posix(), text))
    return found


def tables_in(text: str) -> Iterator[tuple[str, str]]:
    """List the tables of a graph with a type, each with its tables of groups: the type, and the text."""
    for part in re.split(r"\n(?=\[(?:wedge\.)?[^\].]+\])", text):
        if part.startswith("[") and not part.startswith("[wedge."):
            [table] = tomllib.loads(part).values()
            if "type" in table:
                yield table["type"], COMMENTS_AT_END.sub("", part).strip()


def example_of(node_type: NodeType) -> tuple[str, str]:
    """Return where an example of a node type is from, and its text; what it needs at least where no graph has one."""
    known = tables().get(node_type.name, [])
    short = [entry for entry in known if len(entry[1].splitlines()) <= LONGEST]
    return (short or known or [("", least_of(node_type))])[0]


def least_of(node_type: NodeType) -> str:
    """Write a table with the edges and settings that have to be given."""
    edges = [f'in.{name} = "{name}"' for name, socket in node_type.sockets.items() if not socket.optional]
    settings = [f"# {field.name} = {field.allowed}" for field in fields_of(node_type) if field.required]
    return "\n".join([f"[{node_type.name}]", f'type = "{node_type.name}"', *edges, *settings])
