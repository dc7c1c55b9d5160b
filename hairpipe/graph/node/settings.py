"""Settings: checks, plain values for keys and jobs, and Python objects for calls of nodes."""

import dataclasses
import json
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin

from hairpipe.errors import BadInput
from hairpipe.graph.node.declare import NodeType
from hairpipe.graph.node.fields import Field, fields_of, finite
from hairpipe.graph.node.messages import cut, nearest

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic_core import ErrorDetails

Plain = dict[str, Any]
Place = Callable[[Sequence[str]], str]
"""Returns the file and line of the setting with these names."""


class Missing(BadInput):
    """A required setting is absent."""


def check_settings(node_type: NodeType, given: Plain, place: Place) -> Plain:
    """Check the settings of a graph file, add defaults, and convert whole numbers to declared floats.

    Returns plain values (None, bool, int, float, str, list, dict); a file is its path in the graph file.
    Raises BadInput with the field, its value, and the permitted values.
    """
    from pydantic import ValidationError

    fields = fields_of(node_type)
    try:
        text = json.dumps(merge_defaults(fields, given))
        model = model_of(node_type).model_validate_json(text, strict=True)
    except ValidationError as error:
        raise explain(error.errors(include_url=False)[0], fields, place) from None
    except TypeError:
        raise BadInput("a setting cannot be a date or a time", where=place([])) from None
    except (ValueError, RecursionError) as error:
        raise BadInput(f"settings cannot be read: {error}", where=place([])) from None
    plain = model.model_dump(mode="json")
    try:
        built = build_settings(node_type, plain)
        if grouped := getattr(node_type.function, "grouped", None):
            grouped(built)
    except (ValueError, BadInput) as error:
        raise BadInput(str(error), where=place([])) from None
    return plain


def build_settings(node_type: NodeType, plain: Plain) -> dict[str, Any]:
    """Convert checked plain values to the arguments of the node."""
    return {field.name: build(field, plain[field.name]) for field in fields_of(node_type)}


def build(field: Field, value: Any) -> Any:
    """Convert one plain value to the type of its annotation; BadInput if a group refuses its fields."""
    if value is None:
        return None
    if field.group:
        try:
            return field.base(**{inner.name: build(inner, value[inner.name]) for inner in field.group})
        except BadInput as error:
            raise BadInput(str(error), where=field.name) from None
    return build_plain(field.base, value)


def build_plain(kind: Any, value: Any) -> Any:
    """Convert one plain value that is not a group; tuples can be nested."""
    if get_origin(kind) is Annotated:
        return build_plain(get_args(kind)[0], value)
    if get_origin(kind) is tuple:
        items = get_args(kind)
        kinds = items[:1] * len(value) if items[-1] is Ellipsis else items
        return tuple(build_plain(inner, item) for inner, item in zip(kinds, value, strict=True))
    return Path(value) if kind is Path else value


def map_files(fields: Iterable[Field], plain: Plain, change: Callable[[str, str], Any]) -> Plain:
    """Return plain settings with every file replaced by `change(dotted name, path)`."""
    return map_values(fields, plain, lambda field, name, value: change(name, value) if field.base is Path else value)


def map_values(
    fields: Iterable[Field], plain: Plain, change: Callable[[Field, str, Any], Any], prefix: str = ""
) -> Plain:
    """Return plain settings with every value but None replaced by `change(field, dotted name, value)`."""
    changed = dict(plain)
    for field in fields:
        value = plain[field.name]
        name = prefix + field.name
        if value is not None:
            inner = field.group
            changed[field.name] = map_values(inner, value, change, name + ".") if inner else change(field, name, value)
    return changed


def merge_defaults(fields: Iterable[Field], given: Plain) -> Plain:
    """Merge values into the default of their group, unless it is None.

    A plain value in place of a group with a field `value` is the value of that field; `false` in place of an optional
    group leaves it out, whatever its default is.
    """
    merged = dict(given)
    for field in fields:
        has_default = dataclasses.is_dataclass(field.default)
        value = given.get(field.name, {} if has_default else None)
        if field.group and field.optional and value is False:
            merged[field.name] = value = None
        if field.shorthand and value is not None and not isinstance(value, dict):
            value = {field.shorthand.name: value}
        if field.group and isinstance(value, dict):
            base = json.loads(json.dumps(dataclasses.asdict(field.default), default=str)) if has_default else {}
            merged[field.name] = merge_defaults(field.group, {**base, **value})
    return merged


@cache
def model_of(node_type: NodeType) -> "type[BaseModel]":
    """Build the pydantic model of a node type's settings."""
    return make_model(node_type.name, fields_of(node_type))


def make_model(name: str, fields: Iterable[Field]) -> "type[BaseModel]":
    """Build a model without unknown names, NaN and infinity; the only conversion is int to float."""
    from pydantic import ConfigDict, create_model

    config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, validate_default=True)
    entries = {}
    for field in fields:
        kind = make_model(field.name, field.group) if field.group else field.annotation
        required = field.required or dataclasses.is_dataclass(field.default)  # merge_defaults has filled that in
        entries[field.name] = (kind | None if field.optional else kind, ... if required else field.default)
    return create_model(name, __config__=config, **entries)


def explain(error: "ErrorDetails", fields: tuple[Field, ...], place: Place) -> BadInput:
    """Convert an error of pydantic to a BadInput: the field, its value, and the permitted values."""
    names = []
    known = fields
    field = None
    for part in map(str, error["loc"]):
        if field is not None and not field.group:
            break  # an index into a list
        names.append(part)
        field = next((f for f in known if f.name == part), None)
        known = field.group if field else known
    dotted = ".".join(names)
    where = place(names)
    if error["type"] == "extra_forbidden":
        return BadInput(f"unknown setting '{dotted}'", where=where, right=nearest(names[-1], [f.name for f in known]))
    if error["type"] == "missing" and len(names) == len(error["loc"]):
        return Missing(f"setting '{dotted}' is missing", where=where, right=field and field.allowed)
    given = cut(json.dumps(error["input"], default=str))
    fault = "is not allowed" if finite(error["input"]) else "is not a finite number"
    right = field.allowed if field else error["msg"]
    if field and field.group:
        right += f": {', '.join(inner.name for inner in field.group)}"
    return BadInput(f"{dotted} = {given} {fault}", where=where, right=right)
