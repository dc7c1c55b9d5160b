"""Merges variants of a graph into one graph: common nodes once, differing nodes under names of their own."""

from collections.abc import Iterable
from copy import deepcopy
from typing import Any

from hairpipe.graph.file.overrides import Tables, drop, put
from hairpipe.graph.store.digest import digest
from hairpipe.tune.simplifications import Simplification

MARK = 8
"""Characters of the digest that distinguishes variants of a node."""


def simplified(tables: Tables, parts: Iterable[Simplification]) -> Tables:
    """Return the tables of a graph with simplifications applied; pure."""
    tables = deepcopy(tables)
    for part in parts:
        for target in part.drops:
            drop(tables, target)
        for target, value in part.puts:
            put(tables, target, value)
    return tables


def with_node(tables: Tables, name: str, table: Tables, instead: str | None = None) -> Tables:
    """Return the tables with a node more; pure.

    instead  edge whose consumers take the new node's value from now on
    """
    tables = deepcopy(tables)
    for other in nodes_of(tables).values() if instead is not None else ():
        other["in"] = map_edges(other.get("in", {}), lambda edge: name if edge == instead else edge)
    return tables | {name: table}


def merged_variants(variants: dict[str, Tables], node: str) -> tuple[Tables, dict[str, str]]:
    """Return one graph that holds a node of every variant with its dependencies, and its name there by variant.

    Nothing is published. A node keeps its name, followed by a digest of all that it depends on.
    """
    merged: Tables = {}
    names = {label: gather(merged, tables, node, {}) for label, tables in variants.items()}
    first = next(iter(variants.values()))
    return {key: value for key, value in first.items() if not isinstance(value, dict)} | merged, names


def gather(merged: Tables, tables: Tables, node: str, known: dict[str, str]) -> str:
    """Add a node and its dependencies to merged tables, in place, and return its name there."""
    if node not in known:
        table = {key: value for key, value in tables[node].items() if key != "publish"}

        def renamed(edge: str) -> str:
            source, dot, output = edge.partition(".")
            return gather(merged, tables, source, known) + dot + output

        if "in" in table:
            table["in"] = map_edges(table["in"], renamed)
        known[node] = f"{node}-{digest('node', plain(table))[:MARK]}"
        merged[known[node]] = table
    return known[node]


def map_edges(edges: Tables, change: Any) -> Tables:
    """Return a table `in` with every edge changed; pure."""
    return {
        socket: [change(edge) for edge in value] if isinstance(value, list) else change(value)
        for socket, value in edges.items()
    }


def nodes_of(tables: Tables) -> Tables:
    """Return the tables that are nodes."""
    return {name: table for name, table in tables.items() if isinstance(table, dict)}


def plain(value: Any) -> Any:
    """Return a value of TOML as one that can be digested."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value if isinstance(value, bool | int | float | str) else str(value)
