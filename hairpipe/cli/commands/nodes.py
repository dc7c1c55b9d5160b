"""`hairpipe nodes`: which node types there are, and what they take and give."""

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hairpipe.cli import completion, options
from hairpipe.cli.shipped import find_graph
from hairpipe.cli.wording import table
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from hairpipe.graph.file.registry import Registry
    from hairpipe.graph.node.declare import NodeType, Socket
    from hairpipe.graph.node.fields import Field

VIEWS = {
    "now": "",
    "pair": "previous and this frame",
    "frames": "all frames",
    "reached": "all frames that were reached",
}
MODES = {
    "once": "one value for the shot",
    "each": "one value per frame",
    "scan": "one value per frame, from the one before",
}


@click.command()
@click.argument("name", metavar="[TYPE]", required=False, shell_complete=completion.complete_type)
@click.option("--graph", shell_complete=completion.complete_graph, help="Also the types in `nodes` beside this graph.")
@options.as_json
def nodes(name: str | None, graph: str | None, as_json: bool) -> None:
    """List the node types, or describe one.

    Of one: inputs, outputs, and settings with unit, range and default.
    """
    from hairpipe.graph.file.registry import Registry

    catalogue = Registry(find_graph(graph).parent / "nodes" if graph else None)
    if name is not None:
        node_type = catalogue.find(name)
        click.echo(json.dumps(document(node_type), indent=2) if as_json else text(node_type))
    elif as_json:
        click.echo(json.dumps({"nodes": [entry(catalogue, name) for name in catalogue.names()]}, indent=2))
    else:
        click.echo(table([(name, summary(catalogue, name)) for name in catalogue.names()], "<<"))


def summary(catalogue: "Registry", name: str) -> str:
    """Give the first line of a node type's help, or say why it cannot be loaded."""
    from hairpipe.graph.file.trust import Untrusted

    try:
        return catalogue.find(name).summary
    except Untrusted as doubt:
        return f"(not trusted: hairpipe trust {doubt.folder})"
    except BadInput as fault:
        return f"({fault})"


def entry(catalogue: "Registry", name: str) -> dict[str, Any]:
    """Describe a node type as a JSON document, or say why it cannot be loaded."""
    try:
        return document(catalogue.find(name))
    except BadInput as fault:
        return {"name": name, "fault": str(fault)}


def text(node_type: "NodeType") -> str:
    """Describe a node type."""
    from hairpipe.graph.node.fields import fields_of

    parts = [f"{node_type.name}: {MODES[node_type.mode]}\n{node_type.summary}"]
    parts += part("inputs", [(s.name, describe_socket(s)) for s in node_type.sockets.values()])
    parts += part(
        "outputs", [(name or kind.__name__, kind.__name__ * bool(name)) for name, kind in node_type.outputs.items()]
    )
    parts += part("settings", [row for field in fields_of(node_type) for row in rows_of(field, "")])
    return "\n\n".join(parts)


def part(title: str, rows: list[tuple[str, str]]) -> list[str]:
    """Lay out rows below a title; nothing where there are none."""
    return [f"{title}\n" + "\n".join(f"  {line}" for line in table(rows, "<<").splitlines())] if rows else []


def describe_socket(socket: "Socket") -> str:
    """Say what goes into a socket."""
    words = [socket.type.__name__, "any number" * socket.many, VIEWS[socket.view], "optional" * socket.optional]
    return ", ".join(filter(None, words))


def rows_of(field: "Field", prefix: str) -> Iterator[tuple[str, str]]:
    """Describe a setting on two rows, a group field by field: dotted name and what is allowed; what it is."""
    absent = ", absent by default" if field.default is None else ", required" if field.required else ""
    yield prefix + field.name, field.allowed + absent
    if field.help:
        yield "", field.help
    for inner in fields_within(field):
        yield from rows_of(inner, f"{prefix}{field.name}.")


def fields_within(field: "Field") -> tuple["Field", ...]:
    """List the fields of a group, with the defaults that the group has here."""
    if not dataclasses.is_dataclass(field.default):
        return field.group
    return tuple(dataclasses.replace(inner, default=getattr(field.default, inner.name)) for inner in field.group)


def document(node_type: "NodeType") -> dict[str, Any]:
    """Describe a node type as a JSON document."""
    from hairpipe.graph.node.fields import fields_of

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


def described(field: "Field") -> dict[str, Any]:
    """Describe a setting as a JSON document."""
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
