"""Edits of a graph as edits of its text: comments, order and everything else in it are kept.

A text is divided into statements: headers, values of one or more lines, comments, blank lines. An edit adds, removes or
replaces statements, and is refused where the tables of its text would not be those that are wanted. Every function
takes the text of a file and returns another one, pure; BadInput where the text does not permit the edit. A graph file
is written with its permissions, owner and links.
"""
# pyright: reportGeneralTypeIssues=false

import fcntl
import hashlib
import json
import os
import re
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import lru_cache, reduce
from operator import getitem
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import InlineTable

from hairpipe.engine.file.overrides import LAYOUT, WEDGE, nodes_of
from hairpipe.engine.file.read import NAME, Location, read_graph_text
from hairpipe.engine.node.settings import SHORTHAND
from hairpipe.engine.store.atomic import overwrite, write_text
from hairpipe.engine.store.ownership import make_own, own_folder
from hairpipe.errors import BadInput

KEY = re.compile(rf"[ \t]*({NAME}(?:[ \t]*\.[ \t]*{NAME})*)[ \t]*=")
HEADER = re.compile(rf"[ \t]*\[\[?[ \t]*({NAME}(?:[ \t]*\.[ \t]*{NAME})*)[ \t]*\]")
PART = re.compile(NAME)
BARE = re.compile(r"[A-Za-z0-9_-]+")
LONGEST = 200
"""Maximum number of lines of one value."""
WIDEST = 120
"""Maximum length of a line that is written for a group."""

Names = tuple[str, ...]


class Statement(NamedTuple):
    """Lines of a graph file that belong together."""

    kind: str  # "header", "value", "comment" or "blank"
    text: str  # with the end of the last line
    path: Names  # names from the root to a table or value; of a comment or blank line those of the table around it
    header: Names  # path of the table in which it is

    @property
    def key(self) -> Names:
        return self.path[len(self.header) :]

    def renamed(self, depth: int, name: str) -> "Statement":
        """Return a header or value with another name in its path, or unchanged if the table around it has the name."""
        path = (*self.path[:depth], name, *self.path[depth + 1 :])
        above = len(self.header) if self.kind == "value" else 0
        header = path[: len(self.header)]
        if depth < above:
            return self._replace(path=path, header=header)
        found = (KEY if self.kind == "value" else HEADER).match(self.text)
        assert found is not None
        part = list(PART.finditer(self.text, found.start(1), found.end(1)))[depth - above]
        text = self.text[: part.start()] + name + self.text[part.end() :]
        return self._replace(path=path, header=header, text=text)


def read_statements(text: str) -> list[Statement]:
    """Divide a text; BadInput for one that is not TOML. The texts of all statements together are the text."""
    lines = re.findall(r"[^\n]*\n|[^\n]+\Z", text)
    found: list[Statement] = []
    header: Names = ()
    place = 0
    while place < len(lines):
        line = lines[place]
        bare = line.strip()
        place += 1
        if not bare or bare.startswith("#"):
            found.append(Statement("comment" if bare else "blank", line, header, header))
        elif match := HEADER.match(line):
            header = names_in(match[1])
            found.append(Statement("header", line, header, header))
        else:
            while not is_complete(line):
                if place == len(lines) or line.count("\n") > LONGEST:
                    raise BadInput("not a value of TOML", where=bare[:80])
                line += lines[place]
                place += 1
            key = KEY.match(line)
            assert key is not None
            found.append(Statement("value", line, (*header, *names_in(key[1])), header))
    return found


def names_in(dotted: str) -> Names:
    return tuple(part[0].strip("\"'") for part in PART.finditer(dotted))


@lru_cache(4096)
def is_complete(text: str) -> bool:
    """Whether lines are TOML, and not the beginning of a value of more lines."""
    try:
        tomllib.loads(text.replace("\r\n", "\n"))
    except (ValueError, RecursionError):
        return False
    return True


def owners(statements: Sequence[Statement]) -> list[str | None]:
    """Return the first name of the table to which each statement belongs; None for the head of the file.

    Comments directly above a header belong to the table below.
    """
    found = [statement.path[0] if statement.path else None for statement in statements]
    attached: str | None = None
    for place in range(len(statements) - 1, -1, -1):
        kind = statements[place].kind
        attached = found[place] if kind == "header" else attached if kind == "comment" else None
        if attached is not None:
            found[place] = attached
    return found


def literal_of(value: Any) -> str:
    """Write a plain value as TOML on one line."""
    if isinstance(value, dict):
        inner = ", ".join(f"{key} = {literal_of(item)}" for key, item in value.items())
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, list):
        return f"[{', '.join(map(literal_of, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, bool | str) else tomlkit.item(value).as_string()


def read_literal(literal: str) -> Any:
    """Read a value of TOML; ValueError for another text."""
    tables = tomllib.loads(f"value = {literal}")
    if tables.keys() != {"value"}:
        raise ValueError("more than a value")
    return tables["value"]


def with_inner(statement: Statement, names: Names, literal: str | None) -> Statement:
    """Return a statement with its value changed, or with a name in its inline table changed, or removed for None.

    A plain value in place of a group becomes the field `value` of the group.
    """
    wanted = changed(reduce(getitem, statement.key, tomllib.loads(statement.text)), names, literal)
    for text in changed_texts(statement, names, literal, wanted):
        with suppress(ValueError, KeyError, TypeError):
            if reduce(getitem, statement.key, tomllib.loads(text)) == wanted:
                return statement._replace(text=text)
    return statement


def changed_texts(statement: Statement, names: Names, literal: str | None, wanted: Any) -> Iterator[str]:
    """Yield the text with a value changed in place, which keeps digits and comments, and with all of it written again.

    An inline table has the spaces within braces that it had before; an empty one had them.
    """
    with suppress(TOMLKitError, ValueError, TypeError, KeyError, AttributeError):
        document: Any = tomlkit.parse(statement.text)
        *above, last = (*statement.key, *names)
        table = reduce(getitem, above, document)
        if isinstance(table, InlineTable if names else MutableMapping):
            if literal is None:
                del table[last]
            else:
                table[last] = tomlkit.value(literal)
            text = document.as_string()
            if names and "\n" not in statement.text.rstrip():
                yield with_spaces(text, "{ " in statement.text or "{}" in statement.text)
            yield text
    with suppress(TOMLKitError, ValueError, TypeError, KeyError, AttributeError):
        document = tomlkit.parse(statement.text)
        *above, last = statement.key
        reduce(getitem, above, document)[last] = tomlkit.value(literal_of(wanted))
        yield document.as_string()


def with_spaces(text: str, within_braces: bool) -> str:
    """Return the text of an inline table with single spaces between, and within its braces or not."""
    text = re.sub(r"([{,]) {2,}", r"\1 ", text)
    if within_braces:
        return re.sub(r"(?<=[^ {]) *\}", " }", re.sub(r"\{(?=[^ }])", "{ ", text))
    return re.sub(r" *\}", "}", text)


def changed(value: Any, names: Names, literal: str | None) -> Any:
    """Return a plain value with an inner one set or removed; a plain value in place of a group is its shorthand."""
    if not names:
        return None if literal is None else read_literal(literal)
    first, *rest = names
    table = dict(value) if isinstance(value, dict) else {} if value is False else {SHORTHAND: value}
    if literal is None and not rest:
        return {name: inner for name, inner in table.items() if name != first}
    return {**table, first: changed(table.get(first, {}), tuple(rest), literal)}


Tables = dict[str, Any]
Edit = Callable[[list[Statement]], list[Statement]]


def with_value(text: str, target: str, literal: str) -> str:
    """Set a value by `node.setting` or `node.group.setting`; a new one is the last line of its table.

    literal  value as TOML, written as given
    """
    return with_path(text, read_target(target, tables_of(text)), literal)


def with_path(text: str, path: Names, literal: str) -> str:
    """Set a value by its path."""
    wanted = changed(tables_of(text), path, literal)
    return checked(text, wanted, lambda given: assigned(given, path, literal, newline_of(text)))


def without_value(text: str, target: str) -> str:
    """Remove a value or group; of a node that is `like` another, `without` leaves a copied group or edge out."""
    path = read_target(target, tables_of(text))
    if holds(tables_of(text), path):
        text = dropped_value(text, path)
    tables = tables_of(text)
    node, *names = path
    table = tables.get(node, {})
    if inherited(tables, table.get("like", ""), tuple(names)):
        left = [*table.get("without", []), ".".join(names)]
        return with_value(text, f"{node}.without", literal_of(left))
    return text


def with_node(text: str, name: str, node_type: str, edges: Mapping[str, str]) -> str:
    """Add a node at the end of the nodes, with edges by socket."""
    tables = tables_of(text)
    check_free(tables, name)
    table = {"type": node_type, **({"in": dict(edges)} if edges else {})}
    lines = [f"type = {literal_of(node_type)}"]
    if len(edges) == 1:
        lines += [f"in.{socket} = {literal_of(source)}" for socket, source in edges.items()]
    elif edges:
        lines.append(f"in = {literal_of(dict(edges))}")
    return with_block(text, name, lines, tables | {name: table})


def without_nodes(text: str, names: Sequence[str]) -> str:
    """Remove nodes, the edges from them, and their positions; BadInput for the base of a remaining node."""
    tables = tables_of(text)
    nodes = nodes_of(tables)
    for name in names:
        check_node(nodes, name)
    for other, table in nodes.items():
        if table.get("like") in names and other not in names:
            right = f"remove '{other}' first"
            raise BadInput(f"'{other}' is like '{table['like']}'", right=right)
        if other not in names:
            text = without_edges(text, other, table, lambda source: source not in names)
    for name in names:
        text = reframed(text, name, None)
    text = placed(text, dict.fromkeys(names))
    wanted = {key: value for key, value in tables_of(text).items() if key not in names}
    return checked(text, wanted, lambda given: without_tables(given, names))


def without_edges(text: str, node: str, table: Mapping[str, Any], kept: Callable[[str], bool]) -> str:
    """Remove the edges of a node, which has this table, from nodes of which `kept` is false."""
    for socket, source in table.get("in", {}).items():
        sources = source if isinstance(source, list) else [source]
        left = [one for one in sources if kept(str(one).partition(".")[0])]
        if left and left != sources:
            text = with_value(text, f"{node}.in.{socket}", literal_of(left))
        elif not left:
            text = dropped_value(text, (node, "in", socket))
    return text


def sources_of(text: str) -> dict[str, str]:
    """Return the text of each table, with the comments above its header."""
    found: dict[str, str] = {}
    given = read_statements(text)
    for one, owner in zip(given, owners(given), strict=True):
        found[str(owner)] = found.get(str(owner), "") + one.text
    return {name: own.strip("\r\n") + newline_of(text) for name, own in found.items()}


def pasted(text: str, block: str) -> tuple[str, dict[str, str]]:
    """Add the nodes of another text, without edges from elsewhere; return also their names by those in the text.

    A node whose name is taken has a new name, and publishes nothing. BadInput for a text of anything but nodes.
    """
    tables = tables_of(block)
    for name, table in tables.items() or [("", None)]:
        if not isinstance(table, dict) or not isinstance(table.get("in", {}), dict) or name not in nodes_of(tables):
            what = f"'{name[:60]}' is not a node" if name else "no nodes"
            raise BadInput(what, where="the clipboard", right='tables such as [head] with type = "make_bust"')
        if table.get("like", name) not in tables:
            raise BadInput(f"'{name[:60]}' is like '{table['like']}'", where="the clipboard", right="both")
        block = without_edges(block, name, table, tables.__contains__)
    names = dict[str, str]()
    for old in tables:
        taken = [*tables_of(text), *tables_of(text).get(LAYOUT, {})]
        names[old] = free_name(taken, old)
        if names[old] != old:
            names[old] = free_name([*taken, *tables_of(block)], old.rstrip("0123456789").rstrip("_"))
            block = renamed(block, old, names[old])
            block = without_value(block, f"{names[old]}.publish")
    newline = newline_of(text)
    lines = read_statements(newline.join(block.strip().splitlines()) + newline)
    wanted = tables_of(text) | tables_of(block)
    return checked(text, wanted, lambda given: inserted(given, lines, newline)), names


def with_header(text: str, name: str, literal: str) -> str:
    """Set a value of the shot, such as `frames`; a new one follows the others above the tables."""
    return with_path(text, (name,), literal)


def with_tables(text: str, head: Tables, tables: Mapping[str, Tables], owned: Iterable[str]) -> str:
    """Set values of the shot and whole tables; a value that is equal keeps its text, and other tables are kept.

    head    values of the shot, such as `frames`
    tables  plain values of each table by its name
    owned   names of nodes, or the beginning of names and `*`: those that are not in `tables` are removed
    """
    for name, value in [*head.items(), *tables.items()]:
        check_plain_value(value, (name,))
    gone = [name for name in nodes_of(tables_of(text)) if name not in tables and is_owned(name, owned)]
    wanted = {name: table for name, table in tables_of(text).items() if name not in gone}
    text = checked(text, wanted, lambda given: without_tables(given, gone))
    for path, value in differences(tables_of(text), head, ()):
        text = with_path(text, path, literal_of(value))
    for name, table in tables.items():
        text = with_table(text, name, table)
    return text


def is_owned(name: str, owned: Iterable[str]) -> bool:
    return any(name == one or (one.endswith("*") and name.startswith(one[:-1])) for one in owned)


def check_plain_value(value: Any, path: Names) -> None:
    """Check that a value can be written as TOML, with keys that need no quotes; BadInput for any other."""
    where = Location(f"[{path[0]}] {'.'.join(path[1:])}".rstrip(), path[0], path[1:])
    if not BARE.fullmatch(path[-1]):
        raise BadInput(f"'{path[-1][:60]}' is not a name", where=where, right="letters, digits, - and _")
    if isinstance(value, dict):
        for name, inner in value.items():
            check_plain_value(inner, (*path, name))
    elif isinstance(value, list):
        for inner in value:
            check_plain_value(inner, path)
    elif not isinstance(value, bool | int | float | str):
        raise BadInput(f"{value} is not a value of TOML", where=where, right="a number, a text, true, false or a list")


def differences(old: Tables, new: Tables, path: Names) -> Iterator[tuple[Names, Any]]:
    """List the values of a table that another one does not have, with their paths, recursively through groups."""
    for name, value in new.items():
        before = old.get(name)
        if isinstance(before, dict) and isinstance(value, dict):
            yield from differences(before, value, (*path, name))
        elif name not in old or not is_same(before, value):
            yield (*path, name), value


def is_same(value: Any, other: Any) -> bool:
    """Whether two plain values are equal; 24 is the same as 24.0, but not true the same as 1."""
    if isinstance(value, list) and isinstance(other, list):
        return len(value) == len(other) and all(map(is_same, value, other))
    if isinstance(value, dict) and isinstance(other, dict):
        return value.keys() == other.keys() and all(is_same(value[name], other[name]) for name in value)
    return value == other and isinstance(value, bool) == isinstance(other, bool)


def with_table(text: str, name: str, table: Tables) -> str:
    """Set a whole table; in place where its layout permits that, otherwise as a new table."""
    tables = tables_of(text)
    if isinstance(tables.get(name), dict):
        with suppress(BadInput):
            edited = text
            for path, _ in differences(table, tables[name], (name,)):
                if not holds(table, path[1:]):
                    edited = dropped_value(edited, path)
            for path, value in differences(tables[name], table, (name,)):
                edited = with_path(edited, path, literal_of(value))
            if is_same(tables_of(edited)[name], table):
                return edited
    newline = newline_of(text)

    def rewritten(given: list[Statement]) -> list[Statement]:
        kept = [one for one in given if one.kind in ("comment", "blank") or one.path[0] != name]
        return inserted(kept, block_of((name,), table, newline), newline)

    return checked(text, {**tables, name: table}, rewritten)


def block_of(path: Names, table: Tables, newline: str) -> list[Statement]:
    """Write a table with a value a line; a group is on one line, or a table of its own where that is too long."""
    lines = [Statement("header", f"[{'.'.join(path)}]{newline}", path, path)]
    below = list[Statement]()
    for name, value in table.items():
        key = name
        shown = value
        if isinstance(value, dict) and len(value) == 1:
            [(inner, shown)] = value.items()
            key = f"{name}.{inner}"
        line = f"{key} = {literal_of(shown)}{newline}"
        if isinstance(value, dict) and len(line) > WIDEST:
            below += [Statement("blank", newline, path, path), *block_of((*path, name), value, newline)]
        else:
            lines.append(Statement("value", line, (*path, name), path))
    return lines + below


def renamed(text: str, old: str, new: str) -> str:
    """Rename a node, and all references to it: edges, `like`, its position, and names in frames and wedges."""
    check_node(nodes_of(tables_of(text)), old)
    check_free(tables_of(text), new)
    text = reframed(text, old, new)
    tables = tables_of(text)
    wanted = renamed_key(tables, old, new)
    for name, table in nodes_of(wanted).items():
        wanted[name] = table | {key: renamed_texts(table[key], old, new) for key in ("in", "like") if key in table}
    if LAYOUT in wanted:
        wanted[LAYOUT] = renamed_key(wanted[LAYOUT], old, new)
    for name, wedge in renamed_texts(wanted.get(WEDGE, {}), old, new).items():
        axes = wedge.get("axes") if isinstance(wedge, dict) else None
        if isinstance(axes, dict):
            wedge = wedge | {"axes": renamed_key(axes, old, new)}
        wanted[WEDGE] = wanted[WEDGE] | {name: wedge}
    return checked(text, wanted, lambda given: [renamed_in(statement, old, new) for statement in given])


def duplicated(text: str, old: str, new: str, *, like: bool = False) -> str:
    """Add a copy of a node below it, which publishes nothing; with `like`, a copy that states only differences."""
    tables = tables_of(text)
    check_node(nodes_of(tables), old)
    check_free(tables, new)
    if like:
        return with_block(text, new, [f"like = {literal_of(old)}"], tables | {new: {"like": old}})
    copy = {key: value for key, value in tables[old].items() if key != "publish"}

    def copied(given: list[Statement]) -> list[Statement]:
        own = [one for one in given if one.path[:1] == (old,) and one.kind != "comment"]
        lines = dropped([one if one.kind == "blank" else one.renamed(0, new) for one in own], (new, "publish"))
        if own[0].kind == "header":
            return inserted(given, lines, newline_of(text))
        place = given.index(own[-1]) + 1
        return [*given[:place], *lines, *given[place:]]

    return checked(text, tables | {new: copy}, copied)


def placed(text: str, positions: Mapping[str, Any]) -> str:
    """Set positions of nodes on the page, frames and notes, or remove them for None; nothing else depends on them."""
    for name, position in positions.items():
        path = (LAYOUT, name)
        if position is not None:
            text = with_path(text, path, literal_of(position))
        elif holds(tables_of(text), path):
            text = dropped_value(text, path)
    tables = tables_of(text)
    if tables.get(LAYOUT) == {}:
        wanted = {name: table for name, table in tables.items() if name != LAYOUT}
        text = checked(text, wanted, lambda given: without_tables(given, [LAYOUT]))
    return text


def reframed(text: str, old: str, new: str | None) -> str:
    """Rename a node in the frames of the page, or remove it for None; a frame without nodes is removed."""
    for name, frame in tables_of(text).get(LAYOUT, {}).items():
        if isinstance(frame, dict) and old in frame.get("nodes", ()):
            nodes = [new if node == old else node for node in frame["nodes"] if new or node != old]
            text = placed(text, {name: frame | {"nodes": nodes} if nodes else None})
    return text


def free_name(taken: Iterable[str], name: str) -> str:
    """Return the name, or the name with a number, that is not taken."""
    known = {*taken, WEDGE, LAYOUT}
    return name if name not in known else next(f for n in range(2, 10**6) if (f := f"{name}_{n}") not in known)


def check_node(nodes: Tables, name: str) -> None:
    if name not in nodes:
        raise BadInput(f"no node '{name[:60]}'", right="a node of the graph")


def check_free(tables: Tables, name: str) -> None:
    """Refuse the name of a table that exists, or of a frame of the page."""
    if name in tables or isinstance(tables.get(LAYOUT, {}).get(name), dict):
        raise BadInput(f"'{name[:60]}' exists", right="a name of its own")


@lru_cache(maxsize=8)  # an edit looks at its text several times, and the next one begins with the result
def tables_of(text: str) -> Tables:
    """Read the tables of a text, which all callers share: do not change them; BadInput for one that is not TOML."""
    try:
        return tomllib.loads(text.replace("\r\n", "\n"))
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not valid TOML: {error}") from None


def checked(text: str, wanted: Tables, edit: Edit) -> str:
    """Edit the statements of a text; BadInput where the result is not what is wanted."""
    try:
        found = "".join(statement.text for statement in edit(read_statements(text)))
        if tables_of(found) == wanted:
            return found
    except (ValueError, KeyError, AssertionError, StopIteration):
        pass
    raise BadInput("the edit cannot be written without a change of the layout", right="a line written by hand")


def read_target(target: str, tables: Tables) -> Names:
    """Read `node.setting`; BadInput for another text, an unknown node, and more or less than one input of it."""
    path = names_in(target)
    known = len(path) > 1 and isinstance(tables.get(path[0], {} if path[0] == LAYOUT else None), dict)
    if target.count(".") + 1 != len(path) or not known or (path[1] == "in" and len(path) != 3):
        raise BadInput(f"cannot set '{target[:80]}'", right="node.setting")
    return path


def assigned(given: list[Statement], path: Names, literal: str, newline: str) -> list[Statement]:
    """Set a value: in its statement, in the inline table around it, or in a new line."""
    for place, one in enumerate(given):
        if one.kind == "value" and path[: len(one.path)] == one.path:
            return [*given[:place], with_inner(one, path[len(one.path) :], literal), *given[place + 1 :]]
    given = dropped(given, path)
    depth = max((shared(one.path, path) for one in given if one.kind in ("header", "value")), default=0)
    if not depth and len(path) > 1:
        header = Statement("header", f"[{path[0]}]{newline}", path[:1], path[:1])
        line = Statement("value", f"{'.'.join(path[1:])} = {literal}{newline}", path, path[:1])
        return inserted(given, [header, line], newline)
    near = [
        (len(one.header), place)
        for place, one in enumerate(given)
        if one.kind in ("header", "value")
        and path[: len(one.header)] == one.header
        and (len(path) == 1 or shared(one.path, path))
    ]
    _, last = max(near)  # the last line of the innermost table
    header = given[last].header
    line = Statement("value", f"{'.'.join(path[len(header) :])} = {literal}{newline}", path, header)
    return [*ended(given[: last + 1], newline), line, *given[last + 1 :]]


def dropped(given: Iterable[Statement], path: Names) -> list[Statement]:
    """Remove the statements of a value or group, or its name from the inline table around it."""
    kept = []
    for one in given:
        if one.kind == "value" and len(one.path) < len(path) and path[: len(one.path)] == one.path:
            kept.append(with_inner(one, path[len(one.path) :], None))
        elif one.kind in ("comment", "blank") or one.path[: len(path)] != path:
            kept.append(one)
    return kept


def dropped_value(text: str, path: Names) -> str:
    """Remove a value, and a table of edges that is empty then."""
    wanted = changed(tables_of(text), path, None)
    if path[1:-1] == ("in",) and not wanted[path[0]]["in"]:
        return dropped_value(text, path[:2])
    return checked(text, wanted, lambda given: dropped(given, path))


def without_tables(given: list[Statement], names: Sequence[str]) -> list[Statement]:
    """Remove whole tables with their comments, and blank lines that are at the end then."""
    kept = [one for one, owner in zip(given, owners(given), strict=True) if owner not in names]
    while kept and kept[-1].kind == "blank" and kept != given:
        kept.pop()
    return kept


def with_block(text: str, name: str, lines: Sequence[str], wanted: Tables) -> str:
    """Add a table at the end of the nodes."""
    newline = newline_of(text)
    block = [Statement("header", f"[{name}]{newline}", (name,), (name,))]
    block += [Statement("value", line + newline, (name, "type"), (name,)) for line in lines]
    return checked(text, wanted, lambda given: inserted(given, block, newline))


def inserted(given: list[Statement], block: list[Statement], newline: str) -> list[Statement]:
    """Add a table at the end, but before those of wedges and of positions, with a blank line around it."""
    while block[-1].kind == "blank":
        block = block[:-1]
    tail = [WEDGE, LAYOUT]
    place = len(given)
    owned = owners(given)
    while place and not {*tail} & {one.path[0] for one in block if one.path} and owned[place - 1] in tail:
        place -= 1
    before = ended(given[:place], newline)
    blank = Statement("blank", newline, (), ())
    space = [blank] if before and before[-1].kind != "blank" else []
    return [*before, *space, *block, *([blank] if given[place:] else []), *given[place:]]


def ended(given: list[Statement], newline: str) -> list[Statement]:
    """Return statements of which the last one, too, ends its line."""
    if not given or given[-1].text.endswith("\n"):
        return given
    return [*given[:-1], given[-1]._replace(text=given[-1].text + newline)]


def renamed_in(one: Statement, old: str, new: str) -> Statement:
    """Rename a node in one statement: as the name of a table, in the key, and in references."""
    if one.kind not in ("header", "value"):
        return one
    if one.path[0] == old:
        one = one.renamed(0, new)
    elif one.path[:2] == (LAYOUT, old):
        one = one.renamed(1, new)
    elif one.path[0] == WEDGE and one.path[2:4] == ("axes", old):
        one = one.renamed(3, new)
    if one.kind == "value" and (one.path[0] == WEDGE or len(one.path) == 1 or one.path[1] in ("in", "like")):
        for mark in "\"'":
            for end in (mark, "."):
                one = one._replace(text=one.text.replace(f"{mark}{old}{end}", f"{mark}{new}{end}"))
    return one


def renamed_texts(value: Any, old: str, new: str) -> Any:
    """Return a plain value in which each text `old` or `old.name` has the new name; pure."""
    if isinstance(value, dict):
        return {key: renamed_texts(inner, old, new) for key, inner in value.items()}
    if isinstance(value, list):
        return [renamed_texts(inner, old, new) for inner in value]
    if not isinstance(value, str) or value.partition(".")[0] != old:
        return value
    return new + value.removeprefix(old)


def renamed_key(table: Tables, old: str, new: str) -> Tables:
    return {new if key == old else key: value for key, value in table.items()}


def holds(tables: Tables, path: Names) -> bool:
    try:
        reduce(getitem, path, tables)
    except (KeyError, TypeError):
        return False
    return True


def inherited(tables: Tables, base: str, names: Names) -> bool:
    """Whether a node, or one that it is like, has a value."""
    seen = set[str]()
    while isinstance(base, str) and base in tables and base not in seen:
        seen.add(base)
        if holds(tables[base], names):
            return True
        base = tables[base].get("like", "")
    return False


def shared(path: Names, other: Names) -> int:
    return next((n for n, (a, b) in enumerate(zip(path, other, strict=False)) if a != b), min(len(path), len(other)))


def newline_of(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"


BOM = "\ufeff"
PATIENCE = 10.0
"""Longest wait for another process that saves the same file [s]."""


def save_settings(path: Path, settings: Mapping[str, Any]) -> None:
    """Write settings into a graph file; BadInput as for `with_settings`."""
    with locked(path):
        save_text(path, with_settings(read_graph_text(path).text, settings))


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lock a graph file while it is compared and written, against other processes of this user.

    The lock is a file in the state folder of the user, as the graph file itself is replaced by each write. A user
    without a home has no lock. BadInput for a lock that another process keeps.
    """
    with ExitStack() as stack:
        with suppress(OSError):
            folder = own_folder("state") / "saving"
            make_own(folder)
            name = hashlib.blake2b(os.fsencode(path.resolve()), digest_size=16).hexdigest()
            handle = stack.enter_context((folder / name).open("w")).fileno()
            end = time.monotonic() + PATIENCE
            while not is_locked(handle):
                if time.monotonic() > end:
                    raise BadInput("another process has been saving it for long", where=path, right="try again")
                time.sleep(0.005)
        yield


def is_locked(handle: int) -> bool:
    """Lock an open file; False where another process has locked it."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def save_text(path: Path, text: str) -> None:
    """Write a graph file, which may be new; OSError for a file that cannot be written."""
    target = path.resolve()
    found = target.stat() if target.exists() else None
    mark = BOM if found and target.read_bytes().startswith(BOM.encode()) else ""
    if found and (found.st_nlink > 1 or found.st_uid != os.geteuid()):  # a new file would have one name, and be ours
        overwrite(target, (mark + text).encode("utf-8"))
    else:
        write_text(target, mark + text)


def with_settings(text: str, settings: Mapping[str, Any]) -> str:
    """Return the text of a graph file with settings changed, by `node.setting` or `node.group.setting`.

    BadInput if a setting cannot be set, or if the layout of the text does not permit the change.
    """
    for target, value in settings.items():
        text = with_value(text, target, literal_of(value))
    return text
