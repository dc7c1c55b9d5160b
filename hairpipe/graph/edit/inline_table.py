"""Changes of one statement of a graph file: of its value, or within its inline table."""

import json
import re
import tomllib
from collections.abc import MutableMapping
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import InlineTable

from hairpipe.graph.edit.statements import Names, Statement
from hairpipe.graph.node.fields import SHORTHAND


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

    names  below the path of the statement; empty for the value itself

    A plain value in place of a group becomes the field `value` of the group.
    """
    wanted = changed(value_at(tomllib.loads(statement.text), statement.key), names, literal)
    for write in (tidied, edited, rewritten):
        try:
            text = write(statement, names, literal, wanted)
            if value_at(tomllib.loads(text), statement.key) == wanted:
                return statement._replace(text=text)
        except (TOMLKitError, ValueError, TypeError, KeyError, AttributeError):
            continue
    return statement


def changed(value: Any, names: Names, literal: str | None) -> Any:
    """Return a plain value with an inner one set or removed; pure."""
    if not names:
        return None if literal is None else read_literal(literal)
    first, *rest = names
    table = group_of(value)
    if literal is None and not rest:
        return {name: inner for name, inner in table.items() if name != first}
    return {**table, first: changed(table.get(first, {}), tuple(rest), literal)}


def group_of(value: Any) -> dict[str, Any]:
    """Return a group; that of a shorthand for a plain value, and an empty one for `false`."""
    return dict(value) if isinstance(value, dict) else {} if value is False else {SHORTHAND: value}


def edited(statement: Statement, names: Names, literal: str | None, wanted: Any) -> str:
    """Change the text in place: numbers keep their digits, and comments stay."""
    document = tomlkit.parse(statement.text)
    table: Any = document
    for name in (*statement.key, *names)[:-1]:
        table = table[name]
    last = (*statement.key, *names)[-1]
    if not isinstance(table, MutableMapping) or (names and not isinstance(table, InlineTable)):
        raise ValueError("not an inline table")
    if literal is None:
        del table[last]
    else:
        table[last] = tomlkit.value(literal)
    return document.as_string()


def tidied(statement: Statement, names: Names, literal: str | None, wanted: Any) -> str:
    """Change the text in place, with the spaces within braces that it had; an empty table had them."""
    text = edited(statement, names, literal, wanted)
    if len(names) and "\n" not in statement.text.rstrip():
        text = re.sub(r"([{,]) {2,}", r"\1 ", text)
        if "{ " in statement.text or "{}" in statement.text:
            text = re.sub(r"(?<=[^ {]) *\}", " }", re.sub(r"\{(?=[^ }])", "{ ", text))
        else:
            text = re.sub(r" *\}", "}", text)
    return text


def rewritten(statement: Statement, names: Names, literal: str | None, wanted: Any) -> str:
    """Write the whole value again; the comment behind it stays."""
    document: Any = tomlkit.parse(statement.text)
    table = document
    for name in statement.key[:-1]:
        table = table[name]
    table[statement.key[-1]] = tomlkit.value(literal_of(wanted))
    return document.as_string()


def value_at(tables: Any, names: Names) -> Any:
    """Return the value at a path of tables; KeyError for a missing one."""
    for name in names:
        tables = tables[name]
    return tables
