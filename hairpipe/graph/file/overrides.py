"""Changes to the tables of a graph before the checks, by the command line or by variants.

A target is `node.setting` or `node.group.setting`.
"""

import tomllib
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.node.messages import listed, nearest

Tables = dict[str, Any]
WEDGE, LAYOUT = "wedge", "layout"
"""Tables of the wedges, by name, and of positions on the page; all other tables are nodes."""


def nodes_of(tables: Tables) -> Tables:
    """Return the tables that are nodes."""
    return {name: table for name, table in tables.items() if isinstance(table, dict) and name not in (WEDGE, LAYOUT)}


def put(tables: Tables, target: str, value: Any) -> None:
    """Set a setting, or a group of them; in place."""
    node, *names = target.split(".")
    nodes = list(nodes_of(tables))
    if node not in nodes or not names or not all(names):
        known = nearest(node, nodes) if node not in nodes and names else f"NODE.SETTING of a node: {listed(nodes)}"
        raise BadInput(f"cannot set '{target}'", where="--set", right=known)
    table = tables[node]
    for name in names[:-1]:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise BadInput(f"'{name}' in '{target}' is not a group", where="--set", right="node.setting=value")
    table[names[-1]] = value


def drop(tables: Tables, target: str) -> None:
    """Remove a setting, or a group of them, if present; in place."""
    *above, last = target.split(".")
    table: Any = tables
    for name in above:
        table = table.get(name) if isinstance(table, dict) else None
    if isinstance(table, dict):
        table.pop(last, None)


def parse_value(text: str) -> Any:
    """Read a value from the command line: TOML if it parses, else the text."""
    try:
        tables = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # no TOML, or a number of thousands of digits
        return text
    return tables["value"] if tables.keys() == {"value"} else text  # a second line may go on with other keys
