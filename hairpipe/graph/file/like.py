"""`like`: a node that copies another node and lists only the differences."""

from collections.abc import Iterator, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.file.overrides import nodes_of
from hairpipe.graph.file.read import GraphText
from hairpipe.graph.node.fields import SHORTHAND
from hairpipe.graph.node.messages import brief, nearest

OWN = frozenset({"like", "without", "publish", "checkpoint", "mute"})
"""Keys without effect on results, which are never copied."""

Table = dict[str, Any]


def written_out(text: GraphText) -> GraphText:
    """Return a graph file with every `like` expanded; BadInput as for `write_out`."""
    return text.edited(text.tables | write_out(text, nodes_of(text.tables)))


def write_out(text: GraphText, tables: dict[str, Table]) -> dict[str, Table]:
    """Return tables with every `like` expanded; pure.

    A node copies type, edges and settings of its base, recursively through groups, and lists the differences.
    `without` lists omitted parts of the base, such as "stiction" or "in.surface"; an omitted group that is also listed
    starts empty. A plain value replaces a group; a group that replaces a plain value starts with it. Bases are
    expanded first. BadInput for an unknown base, a cycle of bases, or a part to omit that the base does not have.
    """
    bases = {name: [base_of(text, name, tables)] if "like" in table else [] for name, table in tables.items()}
    try:
        order = list(TopologicalSorter(bases).static_order())
    except CycleError as error:
        circle = error.args[1]
        where = text.place(circle[-1], ["like"])
        right = "one of them without `like`"
        raise BadInput(f"circular `like`: {' -> '.join(reversed(circle))}", where=where, right=right) from None
    written: dict[str, Table] = {}
    for name in order:
        if not bases[name] and "without" in tables[name]:
            where = text.place(name, ["without"])
            right = 'like = "node"'
            raise BadInput("without, in a node that has no `like`", where=where, right=right)
        base = {key: value for base in bases[name] for key, value in written[base].items() if key not in OWN}
        try:
            written[name] = stated(text, name, tables[name], base)
        except RecursionError:  # a dotted key of a thousand names
            raise BadInput("nested too deeply", where=text.place(name)) from None
    return written


def stated(text: GraphText, name: str, table: Table, base: Table) -> Table:
    """Return the base with the table of a node merged into it, without the omitted parts."""
    for dotted in left_out(text, name, table, base):
        base = without(base, dotted.split("."))
    return merged(base, {key: value for key, value in table.items() if key not in ("like", "without")})


def base_of(text: GraphText, name: str, tables: dict[str, Table]) -> str:
    """Read the name of the base of a node."""
    base = tables[name]["like"]
    where = text.place(name, ["like"])
    if not isinstance(base, str):
        raise BadInput(f"like = {brief(base)} is not the name of a node", where=where, right='like = "node"')
    if base not in tables:
        right = nearest(base, [other for other in tables if other != name])
        raise BadInput(f"like: no node '{base[:60]}'", where=where, right=right)
    return base


def left_out(text: GraphText, name: str, table: Table, base: Table) -> Sequence[str]:
    """Read the dotted names of omitted parts; BadInput for one that the base does not have."""
    given = table.get("without", [])
    where = text.place(name, ["without"])
    if not isinstance(given, list) or not all(isinstance(dotted, str) for dotted in given):
        raise BadInput(f"without = {brief(given)}", where=where, right='a list of names, as ["stiction", "in.body"]')
    known = list(dotted_names(base))
    for dotted in given:
        if dotted not in known:
            what = f"without: '{table['like']}' has no '{dotted[:60]}'"
            raise BadInput(what, where=where, right=nearest(dotted, known))
    return given


def dotted_names(table: Table, prefix: str = "") -> Iterator[str]:
    """List the names in a table, with those in groups as `group.name`."""
    for name, value in table.items():
        yield prefix + name
        if isinstance(value, dict):
            yield from dotted_names(value, f"{prefix}{name}.")


def without(table: Table, names: Sequence[str]) -> Table:
    """Return a table without a dotted name; unchanged if the name is absent."""
    first, *rest = names
    if not rest or not isinstance(table.get(first), dict):
        return {name: value for name, value in table.items() if name != first}
    return {**table, first: without(table[first], rest)}


def merged(base: Table, own: Table) -> Table:
    """Return a table with another merged into it, recursively through groups."""
    result = dict(base)
    for name, value in own.items():
        if isinstance(value, dict) and name in base:
            group = {} if base[name] is False else base[name]
            value = merged(group if isinstance(group, dict) else {SHORTHAND: group}, value)
        result[name] = value
    return result
