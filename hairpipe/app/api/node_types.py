"""Node types: list, inputs, outputs and settings."""

import dataclasses
from functools import lru_cache
from pathlib import Path
from typing import Any

from hairpipe.app.api.source import Source, find_graph
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.file.trust import Untrusted
from hairpipe.engine.node.declare import RESERVED, NodeType, Socket
from hairpipe.engine.node.import_paths import EXPERIMENTS, folder_of
from hairpipe.engine.node.settings import Field, fields_of
from hairpipe.errors import BadInput

__all__ = ["FOLDER", "RESERVED", "Field", "NodeType", "Registry", "Socket", "document", "fields_of"]
__all__ += ["fields_within", "node_types", "summary_of", "type_of"]

FOLDER = "nodes"


def node_types(graph: str | Path | None = None, *, experiments: bool = False) -> Registry:
    """Return the node types of a graph: `names()` lists them, `find(name)` imports one.

    graph        path of a file, or name of a shipped graph; None for the types of every graph
    experiments  without a graph: whether the types of our experiments are included, which only a checkout has
    """
    if graph is not None:
        return Registry(find_graph(graph).parent / FOLDER)
    return Registry(folder_of(EXPERIMENTS) if experiments else None)


def type_of(source: Source, node: str) -> NodeType | None:
    """Find the type of a node in a graph that may have faults; None for a missing or untrusted one."""
    table: Any = source.tables.get(node)
    if not isinstance(table, dict) or not isinstance(table.get("type"), str):
        return None
    try:
        return Registry(source.text.path.parent / FOLDER).find(table["type"])
    except BadInput:
        return None


def summary_of(catalogue: Registry, name: str) -> str:
    """Return the first line of a node type's documentation, or why it cannot be loaded."""
    try:
        return catalogue.find(name).summary
    except Untrusted as error:
        return f"(not trusted: hairpipe trust {error.folder})"
    except BadInput as fault:
        return f"({fault})"


def fields_within(field: Field) -> tuple[Field, ...]:
    """List the fields of a group, with the defaults of this group."""
    if not dataclasses.is_dataclass(field.default):
        return field.group
    return tuple(dataclasses.replace(inner, default=getattr(field.default, inner.name)) for inner in field.group)


@lru_cache(maxsize=512)  # a server imports the types of a user again after each change of their files
def document(node_type: NodeType) -> dict[str, Any]:
    """Describe a node type as a JSON document, which all callers share: do not change it."""
    return {
        "name": node_type.name,
        "mode": node_type.mode,
        "summary": node_type.summary,
        "sockets": [
            {"name": s.name, "type": s.type.__name__, "view": s.view, "optional": s.optional, "many": s.many}
            for s in node_type.sockets.values()
        ],
        "outputs": {name: kind.__name__ for name, kind in node_type.outputs.items()},
        "settings": [described(field) for field in fields_of(node_type)],
    }


def described(field: Field) -> dict[str, Any]:
    group = [described(inner) for inner in fields_within(field)]
    default = None if field.required or group else field.default
    return {
        "name": field.name,
        "kind": field.kind,
        "unit": field.unit,
        "range": field.range,
        "default": str(default) if isinstance(default, Path) else default,
        "required": field.required,
        "optional": field.optional,
        "help": field.help,
        "group": group,
    }


def describe(name: str) -> dict[str, Any]:
    """Return what `hairpipe nodes NAME --json` prints; BadInput where there is no such type."""
    return document(node_types(None).find(name))
