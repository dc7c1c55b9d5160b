"""Shell completion: graphs, node types, nodes, their outputs, settings and values; no untrusted code is run."""

import json
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal, get_args, get_origin

import click
from click.shell_completion import BashComplete, CompletionItem

from hairpipe.engine.file.overrides import nodes_of
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from hairpipe.app.api.node_types import Field
    from hairpipe.app.api.source import Source, Wedge


def complete_graph(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Offer the shipped graphs and files."""
    from hairpipe.app.api.source import shipped_graphs

    names = [CompletionItem(name) for name in shipped_graphs() if name.startswith(incomplete)]
    return [*names, CompletionItem(incomplete, type="file")]


def complete_type(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Offer the node types."""
    from hairpipe.app.api.node_types import node_types

    return [name for name in node_types(experiments=True).names() if name.startswith(incomplete)]


def complete_node(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Offer the nodes of the graph of the command line."""
    source = graph_before(ctx)
    return [name for name in nodes_of(source.tables) if name.startswith(incomplete)] if source else []


def complete_target(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Offer the nodes, and after a dot the outputs of one."""
    node, dot, _ = incomplete.partition(".")
    if not dot:
        return complete_node(ctx, param, incomplete)
    from hairpipe.app.api.node_types import type_of

    source = graph_before(ctx)
    found = type_of(source, node) if source else None
    names = (f"{node}.{output}" for output in found.outputs if output) if found else ()
    return [name for name in names if name.startswith(incomplete)]


def complete_setting(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Offer the nodes, after a dot the settings of one with their defaults, and after = the values."""
    name, equals, _ = incomplete.partition("=")
    node, dot, _ = name.partition(".")
    if not dot:
        nodes = complete_node(ctx, param, incomplete)
        return complete_setting(ctx, param, f"{nodes[0]}.") if len(nodes) == 1 else [f"{found}." for found in nodes]
    from hairpipe.app.api.node_types import fields_of, type_of

    source = graph_before(ctx)
    found = type_of(source, node) if source else None
    if found is None:
        return []

    known = {f"{node}.{setting}": field for setting, field in leaves(fields_of(found), "")}
    near = [setting for setting in known if setting.startswith(name)]
    if equals or len(near) == 1:
        chosen = name if equals else near[0]
        values = values_of(known[chosen]) if chosen in known else []
        return [text for text in (f"{chosen}={value}" for value in values) if text.startswith(incomplete)]
    return [f"{setting}={default_of(known[setting])}" for setting in near]


def complete_wedge(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Offer the wedges of the graph of the command line."""
    return [name for name in wedges_before(ctx) if name.startswith(incomplete)]


def complete_variant(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Offer the variants of the wedge of the command line."""
    found = wedges_before(ctx).get(ctx.params.get("name", ""))
    return [name for name in found.variants if name.startswith(incomplete)] if found else []


def wedges_before(ctx: click.Context) -> "dict[str, Wedge]":
    source = graph_before(ctx)
    try:
        return source.wedges if source else {}
    except BadInput:
        return {}


def graph_before(ctx: click.Context) -> "Source | None":
    from hairpipe.app.api.source import read_source

    given = ctx.params.get("graph") or next(iter(ctx.args), "")  # after `--to` click has not read arguments yet
    try:
        source = read_source(given)
        return source.edited(source.tables)
    except BadInput:
        return None


def leaves(fields: "tuple[Field, ...]", prefix: str) -> "Iterator[tuple[str, Field]]":
    """Iterate over the settings that have a value, those in groups by their dotted names."""
    for field in fields:
        alone = field.shorthand or field
        if not alone.group:
            yield prefix + field.name, alone
        yield from leaves(tuple(inner for inner in field.group if inner is not alone), f"{prefix}{field.name}.")


def values_of(field: "Field") -> list[str]:
    if get_origin(field.base) is Literal:
        return [str(choice) for choice in get_args(field.base)]
    return ["true", "false"] if field.base is bool else [default_of(field)]


def default_of(field: "Field") -> str:
    if isinstance(field.default, str):
        return field.default
    return json.dumps(field.default) if isinstance(field.default, bool | int | float) else ""


class Bash(BashComplete):
    """Completion in bash, where = is a word of its own: the parts are joined, and only the last one is offered."""

    def get_completion_args(self) -> tuple[list[str], str]:
        """Read the words before and at the cursor."""
        args, incomplete = super().get_completion_args()
        if incomplete == "=" and args:
            return args[:-1], f"{args[-1]}="
        if len(args) > 1 and args[-1] == "=":
            return args[:-2], f"{args[-2]}={incomplete}"
        return args, incomplete

    def format_completion(self, item: CompletionItem) -> str:
        """Write the replacement of the word at the cursor."""
        words = os.environ["COMP_WORDS"].split()[: int(os.environ["COMP_CWORD"]) + 1]
        behind = "=" in words[-2:]
        return f"{item.type},{item.value.partition('=')[2] if behind else item.value}"
