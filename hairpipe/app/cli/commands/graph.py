"""Graphs as pictures or data, and descriptions of node types."""

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

import hairpipe
from hairpipe.app.api.formatting import table
from hairpipe.app.cli import options
from hairpipe.app.cli.completion import complete_graph, complete_type
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from hairpipe.app.api.node_types import Field, NodeType, Registry, Socket
    from hairpipe.app.api.shot import Graph


DOT_SHAPES = {"once": "box", "each": "ellipse", "scan": "doubleoctagon"}
MERMAID_SHAPES = {"once": '["{}"]', "each": '(["{}"])', "scan": '[["{}"]]'}


@click.command()
@options.graph
@options.overrides
@options.to
@click.option("--format", "form", type=click.Choice(["dot", "mermaid", "json"]), default="dot", show_default=True)
def graph(graph: str, overrides: dict[str, str], to: tuple[str, ...], form: str) -> None:
    """Print a graph, for other programs to draw.

    The formats are those of graphviz and mermaid, and JSON.

    Boxes are values for the shot, round nodes have one value per frame, double ones continue from the previous frame.
    """
    write = {"dot": as_dot, "mermaid": as_mermaid, "json": lambda graph: json.dumps(graph_document(graph), indent=2)}[
        form
    ]
    opened = hairpipe.load(graph, options.parsed(overrides)).graph
    click.echo(write(opened.upto(to) if to else opened))


def as_dot(graph: "Graph") -> str:
    lines = ["digraph {", "  rankdir=LR"]
    for node in graph.nodes.values():
        lines.append(f'  "{node.name}" [shape={DOT_SHAPES[node.type.mode]} label="{node.name}\\n{node.type.name}"]')
    lines += [f'  "{edge.node}" -> "{node.name}" [label="{plug}"]' for node, plug, edge in graph.consumers()]
    return "\n".join([*lines, "}"])


def as_mermaid(graph: "Graph") -> str:
    """Write a graph in the language of mermaid; names have a prefix, since `end` and others are reserved."""
    lines = ["graph LR"]
    for node in graph.nodes.values():
        lines.append(f"  n_{node.name}" + MERMAID_SHAPES[node.type.mode].format(f"{node.name}<br>{node.type.name}"))
    lines += [f"  n_{edge.node} -->|{plug}| n_{node.name}" for node, plug, edge in graph.consumers()]
    return "\n".join(lines)


def graph_document(graph: "Graph") -> dict[str, Any]:
    nodes = {
        node.name: {
            "type": node.type.name,
            "mode": node.type.mode,
            "in": {plug: edge._asdict() for plug, edge in node.edges.items()},
            "settings": node.settings,
            "publish": None if node.publish is None else str(node.publish),
        }
        for node in graph.nodes.values()
    }
    return {"path": str(graph.path), "frames": list(graph.frames), "fps": graph.fps, "nodes": nodes}


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
@click.argument("name", metavar="[TYPE]", required=False, shell_complete=complete_type)
@click.option("--graph", shell_complete=complete_graph, help="Graph whose folder `nodes` is included.")
@click.option("--all", "everything", is_flag=True, help="Include the types of graphs/experiments, in a checkout.")
@options.as_json
def nodes(name: str | None, graph: str | None, everything: bool, as_json: bool) -> None:
    """List the node types, or describe one.

    Of one: inputs, outputs, and settings with unit, range and default.
    """
    from hairpipe.app.api.node_types import document, node_types, summary_of

    if graph and everything:
        raise click.UsageError("--graph and --all exclude each other: --graph lists all types that a graph finds.")
    catalogue = node_types(graph, experiments=everything or name is not None)
    if name is not None:
        node_type = catalogue.find(name)
        click.echo(json.dumps(document(node_type), indent=2) if as_json else text(node_type))
    elif as_json:
        click.echo(json.dumps({"nodes": [entry(catalogue, name) for name in catalogue.names()]}, indent=2))
    else:
        click.echo(table([(name, summary_of(catalogue, name)) for name in catalogue.names()], "<<"))


def entry(catalogue: "Registry", name: str) -> dict[str, Any]:
    from hairpipe.app.api.node_types import document

    try:
        return document(catalogue.find(name))
    except BadInput as fault:
        return {"name": name, "fault": str(fault)}


def text(node_type: "NodeType") -> str:
    from hairpipe.app.api.node_types import fields_of

    parts = [f"{node_type.name}: {MODES[node_type.mode]}\n{node_type.summary}"]
    parts += part("inputs", [(s.name, describe_socket(s)) for s in node_type.sockets.values()])
    parts += part(
        "outputs", [(name or kind.__name__, kind.__name__ * bool(name)) for name, kind in node_type.outputs.items()]
    )
    parts += part("settings", [row for field in fields_of(node_type) for row in rows_of(field, "")])
    return "\n\n".join(parts)


def part(title: str, rows: list[tuple[str, str]]) -> list[str]:
    return [f"{title}\n" + "\n".join(f"  {line}" for line in table(rows, "<<").splitlines())] if rows else []


def describe_socket(socket: "Socket") -> str:
    words = [socket.type.__name__, "any number" * socket.many, VIEWS[socket.view], "optional" * socket.optional]
    return ", ".join(filter(None, words))


def rows_of(field: "Field", prefix: str) -> Iterator[tuple[str, str]]:
    """Describe a setting on two rows, a group field by field: dotted name and allowed values; help."""
    from hairpipe.app.api.node_types import fields_within

    absent = ", absent by default" if field.default is None else ", required" if field.required else ""
    yield prefix + field.name, field.allowed + absent
    if field.help:
        yield "", field.help
    for inner in fields_within(field):
        yield from rows_of(inner, f"{prefix}{field.name}.")
