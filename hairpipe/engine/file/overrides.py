"""Changes to the tables of a graph before the checks, by the command line or by variants.

A target is `node.setting` or `node.group.setting`. Of a setting that is a number or a table of factors, `length` and
`length.value` are the same: the others of the table stay.
"""

import tomllib
from typing import Any

from hairpipe.engine.file.bounds import KEY
from hairpipe.engine.file.read import Location
from hairpipe.engine.node.declare import RESERVED
from hairpipe.engine.node.messages import listed, nearest
from hairpipe.engine.node.settings import SHORTHAND
from hairpipe.errors import BadInput

Tables = dict[str, Any]
WEDGE, LAYOUT = "wedge", "layout"
"""Tables of the wedges, by name, and of positions on the page; all other tables are nodes."""


def nodes_of(tables: Tables) -> Tables:
    """Return the tables that are nodes."""
    return {name: table for name, table in tables.items() if isinstance(table, dict) and name not in (WEDGE, LAYOUT)}


def put(tables: Tables, target: str, value: Any) -> None:
    """Set a setting, or a group of them; in place."""
    node, *names = target.split(".")
    where = Location("--set", node, names)
    nodes = list(nodes_of(tables))
    if node not in nodes or not names or not all(names):
        known = nearest(node, nodes) if node not in nodes and names else f"NODE.SETTING of a node: {listed(nodes)}"
        raise BadInput(f"cannot set '{target}'", where=where, right=known)
    table = tables[node]
    for name in names[:-1]:
        if isinstance(table.get(name), bool):
            raise BadInput(f"'{name}' in '{target}' is not a group", where=where, right="node.setting=value")
        value_there = table.get(name, {})
        table[name] = table = value_there if isinstance(value_there, dict) else {SHORTHAND: value_there}
    last = names[-1]
    is_group = isinstance(table.get(last), dict) and table[last].keys() != {KEY} and names[0] not in RESERVED
    if is_group and not isinstance(value, dict | bool):
        table[last][SHORTHAND] = value
    else:
        table[last] = value


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
