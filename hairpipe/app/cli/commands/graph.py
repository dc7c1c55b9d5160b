"""`hairpipe graph`: the graph as a picture, or as data."""

import json
from typing import TYPE_CHECKING, Any

import click

import hairpipe
from hairpipe.app.cli import options

if TYPE_CHECKING:
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
    write = {"dot": as_dot, "mermaid": as_mermaid, "json": lambda graph: json.dumps(document(graph), indent=2)}[form]
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


def document(graph: "Graph") -> dict[str, Any]:
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
