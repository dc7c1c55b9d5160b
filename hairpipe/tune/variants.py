"""Merge variants of a graph into one graph: common nodes once, differing nodes under names of their own."""

import importlib
from collections.abc import Iterable
from copy import deepcopy
from typing import Any

from hairpipe.graph.file.overrides import Tables, drop, nodes_of, put
from hairpipe.graph.store.digest import digest
from hairpipe.simplification import Simplification
from hairpipe.tune.sampling import Sample
from hairpipe.tune.simplifications import OUTPUT

MARK = 8
"""Characters of the digest that distinguishes variants of a node."""
KEYS = "-keys"
"""Suffix of the names of nodes of key strands: the thinned groom, and what depends on it."""
SAMPLE = "tune-sample"
"""Name of the node that samples strands."""
MEMBER = "tune-member"
"""Name of the node that makes a member of an ensemble."""
INTERPOLATED = ("body", "ends", "surface", "parts")
"""Sockets that a simulation and an interpolation have in common."""


def simplified(tables: Tables, hair: str, parts: Iterable[Simplification]) -> Tables:
    """Return the tables of a graph with simplifications of a simulation applied; pure."""
    tables = deepcopy(tables)
    every = 1
    others = []
    for part in parts:
        for target in part.drops:
            drop(tables, target)
        for target, value in part.puts:
            put(tables, target, value)
        every = max(every, part.keys)
        others = others + [part] * bool(part.instead)
    if others:
        return with_other_model(tables, hair, others[0])
    return tables if every == 1 else with_keys(tables, hair, every)


def with_keys(tables: Tables, hair: str, every: int) -> Tables:
    """Return the tables with one strand in `every` simulated, and the others interpolated where hair is used; pure."""
    keys = f"{hair}{KEYS}"
    groom = tables[hair]["in"]["groom"]
    interpolated = {socket: edge for socket, edge in tables[hair]["in"].items() if socket in INTERPOLATED}
    table = {"type": "interpolate_hair", "in": {"hair": hair, "keys": keys, "groom": groom} | interpolated}
    for edge in (hair, f"{hair}.{OUTPUT}"):
        tables = with_node(tables, shown_of(hair), table, instead=edge)
    tables[hair]["in"] = map_edges(tables[hair]["in"], lambda edge: of_keys(tables, edge, groom, keys))
    return tables | {keys: {"type": "thin_groom", "in": {"groom": groom}, "every": every}}


def of_keys(tables: Tables, edge: str, groom: str, keys: str) -> str:
    """Return the edge of key strands in place of one of all strands: nodes between are repeated, in place."""
    if edge == groom:
        return keys
    source, dot, output = edge.partition(".")
    table = tables[source]
    edges = table.get("in", {})
    changed = map_edges(edges, lambda other: of_keys(tables, other, groom, keys))
    if changed == edges:
        return edge
    tables[f"{source}{KEYS}"] = {key: value for key, value in table.items() if key != "publish"} | {"in": changed}
    return f"{source}{KEYS}{dot}{output}"


def with_other_model(tables: Tables, hair: str, part: Simplification) -> Tables:
    """Return the tables with other nodes in place of a simulation, see `Simplification.instead`; pure."""
    module, _, function = part.instead.partition(":")
    groom = tables[hair]["in"]["groom"]
    whole = tables[SAMPLE]["in"]["groom"] if groom == SAMPLE else groom
    nodes = getattr(importlib.import_module(module), function)(hair, tables[hair], whole, part)
    return with_node(tables, hair, nodes[hair], instead=f"{hair}.{OUTPUT}") | {
        name: table for name, table in nodes.items() if name != hair
    }


def sampled(tables: Tables, hair: str, sample: Sample) -> Tables:
    """Return the tables of a graph with its hair simulated for a sample only; pure."""
    groom = tables[hair]["in"]["groom"]
    settings = {"strands": sample.strands, "patches": sample.patches, "number": sample.number}
    table = {"type": "sample_groom", "in": {"groom": groom}, **settings}
    return with_node(tables, SAMPLE, table, instead=groom) | {"frames": [sample.begin, sample.last]}


def shown_of(hair: str) -> str:
    """Return the name of the node that interpolates between keys."""
    return f"{hair}-shown"


def with_node(tables: Tables, name: str, table: Tables, instead: str | None = None) -> Tables:
    """Return the tables with another node; pure.

    instead  edge whose consumers take the new node's value from now on
    """
    tables = deepcopy(tables)
    for other in nodes_of(tables).values() if instead is not None else ():
        if "in" in other:
            other["in"] = map_edges(other["in"], lambda edge: name if edge == instead else edge)
    return tables | {name: table}


def merged_variants(variants: dict[str, Tables], nodes: Iterable[str]) -> tuple[Tables, dict[str, list[str]]]:
    """Return one graph that holds nodes of every variant with their dependencies, and their names there by variant.

    A variant may lack some of the nodes. Nothing is published. A node keeps its name, followed by a digest of all that
    determines it.
    """
    merged: Tables = {}
    names = {
        label: [gather(merged, tables, node, {}) for node in nodes if node in tables]
        for label, tables in variants.items()
    }
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


def plain(value: Any) -> Any:
    """Return a value of TOML as one that can be digested."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value if isinstance(value, bool | int | float | str) else str(value)
