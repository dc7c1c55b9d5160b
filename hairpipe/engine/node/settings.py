"""Settings: checks, plain values for keys and jobs, and Python objects for calls of nodes.

Fields: kind, unit, range, choices, default and group of a setting, from its annotation.
"""

import dataclasses
import inspect
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_origin, get_type_hints

from annotated_types import Ge, GroupedMetadata, Gt, Le, Lt, MaxLen, MinLen

from hairpipe.engine.node.declare import NodeType, text_of, without_none
from hairpipe.engine.node.messages import cut, nearest
from hairpipe.errors import BadInput
from hairpipe.units import Calls, Reads, Replaces, Suffixes, Unit

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic_core import ErrorDetails


KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text", Path: "a file"}
BOUNDS = {
    Gt: "> {gt:g}",
    Ge: ">= {ge:g}",
    Lt: "< {lt:g}",
    Le: "<= {le:g}",
    MinLen: "at least {min_length} long",
    MaxLen: "at most {max_length} long",
}
SHORTHAND = "value"
"""Field of a group whose value alone can replace the group in a graph file."""


@dataclass(frozen=True)
class Field:
    """A setting, or a field of a group of settings.

    annotation  in the source, without `| None`
    default     in the source; `inspect.Parameter.empty` if the setting is required
    optional    whether None (absent) is permitted
    group       fields of the group, empty for a single value
    """

    name: str
    annotation: Any
    default: Any
    optional: bool
    help: str
    group: tuple["Field", ...] = ()

    @property
    def required(self) -> bool:
        return self.default is inspect.Parameter.empty

    @property
    def base(self) -> Any:
        """The annotation without unit and range."""
        return get_args(self.annotation)[0] if get_origin(self.annotation) is Annotated else self.annotation

    @property
    def unit(self) -> str | None:
        return next((m.symbol for m in metadata(self.annotation) if isinstance(m, Unit)), None)

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Permitted suffixes of a file, in lower case; empty if all are."""
        return next((m.names for m in metadata(self.annotation) if isinstance(m, Suffixes)), ())

    @property
    def reads(self) -> Reads | None:
        """The files that are read for one of this setting; None if it is that file alone."""
        return next((m for m in metadata(self.annotation) if isinstance(m, Reads)), None)

    @property
    def replaces(self) -> dict[str, str]:
        """What to write in place of former settings, by their names."""
        return dict(next((m.former for m in metadata(self.annotation) if isinstance(m, Replaces)), ()))

    def libraries(self, choice: Any) -> tuple[str, ...]:
        """Names of the modules of libraries that a choice calls, in addition to the imports of the node."""
        return next((m.libraries for m in metadata(self.annotation) if isinstance(m, Calls) and m.choice == choice), ())

    @property
    def range(self) -> str:
        """Bounds, or the suffixes of a file, as text such as `> 0, <= 1`; empty if there are none."""
        known = [m for m in metadata(self.annotation) if type(m) in BOUNDS]
        texts = [BOUNDS[type(bound)].format(**dataclasses.asdict(bound)) for bound in known]
        if self.suffixes:
            *others, last = self.suffixes
            texts.append(f"{', '.join(others)} or {last}" if others else last)
        return ", ".join(texts)

    @property
    def shorthand(self) -> "Field | None":
        """The field `value` of a group, which can replace the group in a graph file; None if absent."""
        return next((field for field in self.group if field.name == SHORTHAND), None)

    @property
    def kind(self) -> str:
        if self.shorthand:
            return f"{kind_text(self.shorthand.annotation)} or a group"
        return "a group" if self.group else kind_text(self.base)

    @property
    def allowed(self) -> str:
        """Kind, unit, range and default in one line."""
        parts = [self.kind + (f" in {self.unit}" if self.unit not in (None, "1") else ""), self.range]
        if not self.required and not self.group and self.default is not None:
            parts.append(f"default {json.dumps(self.default, default=str)}")
        return ", ".join(part for part in parts if part)


@cache
def fields_of(node_type: NodeType) -> tuple[Field, ...]:
    """Describe the settings of a node type; TypeError for an unsupported annotation."""
    document = node_type.function.__doc__ or ""
    return tuple(read_field(s.name, s.annotation, s.default, document) for s in node_type.settings.values())


def field_at(node_type: NodeType, names: Sequence[str]) -> Field | None:
    """Find a setting by its name, after those of its groups; None if it is unknown."""
    known = fields_of(node_type)
    found = None
    for name in names:
        found = next((field for field in known if field.name == name), None)
        known = found.group if found else ()
    return found


def read_field(name: str, annotation: Any, default: Any, document: str) -> Field:
    """Describe one setting; `document` is the docstring with its line `name  text`."""
    bare, optional = without_none(annotation)
    found = Field(name, bare, default, optional, help_line(document, name))
    if isinstance(found.base, type) and dataclasses.is_dataclass(found.base):
        return dataclasses.replace(found, group=tuple(group_fields(found.base)))
    if not is_value(found.base):
        raise TypeError(f"setting '{name}': {text_of(annotation)} is neither a value nor a frozen dataclass of values")
    return found


def group_fields(group: type) -> Iterator[Field]:
    hints = get_type_hints(group, include_extras=True)
    for field in dataclasses.fields(group):
        default = inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default
        if field.default_factory is not dataclasses.MISSING:
            default = field.default_factory()
        yield read_field(field.name, hints[field.name], default, group.__doc__ or "")


def is_value(kind: Any) -> bool:
    """Whether a setting can have this type: plain, a choice, or a tuple of those."""
    if get_origin(kind) is Annotated:
        return is_value(get_args(kind)[0])
    if get_origin(kind) is tuple:
        # Files are keyed by their bytes, one by one.
        return all(is_value(item) and item is not Path for item in get_args(kind) if item is not Ellipsis)
    return kind in KINDS or get_origin(kind) is Literal


def metadata(annotation: Any) -> Iterator[Any]:
    """Iterate over unit and bounds of an annotation; an interval is two bounds."""
    for item in get_args(annotation)[1:] if get_origin(annotation) is Annotated else ():
        yield from item if isinstance(item, GroupedMetadata) else (item,)


def kind_text(kind: Any) -> str:
    if get_origin(kind) is Annotated:
        unit = next((m.symbol for m in metadata(kind) if isinstance(m, Unit)), None)
        return kind_text(get_args(kind)[0]) + (f" in {unit}" if unit not in (None, "1") else "")
    if get_origin(kind) is Literal:
        return "one of " + ", ".join(repr(choice) for choice in get_args(kind))
    if get_origin(kind) is tuple:
        items = get_args(kind)
        if items[-1] is not Ellipsis and len(set(items)) > 1:
            return f"a list: {', '.join(map(kind_text, items))}"
        count = "any number of" if items[-1] is Ellipsis else f"{len(items)} of"
        return f"a list, {count}: {kind_text(items[0])}"
    return KINDS[kind]


def help_line(document: str, name: str) -> str:
    """Find the line `name  text` of a docstring, with its continuation lines, which have the indent of the text."""
    lines = iter(document.splitlines())
    label = re.compile(rf"\s*{re.escape(name)}\s{{2,}}(?=\S)")
    found = next(((line, match.end()) for line in lines if (match := label.match(line))), None)
    if found is None:
        return ""
    first, indent = found
    more = takewhile(lambda line: line.strip() and len(line) - len(line.lstrip()) == indent, lines)
    return " ".join(line.strip() for line in (first[indent:], *more))


def finite(value: Any) -> bool:
    if isinstance(value, dict | list | tuple):
        return all(finite(item) for item in (value.values() if isinstance(value, dict) else value))
    return not isinstance(value, float) or math.isfinite(value)


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
        model = make_model(node_type.name, fields).model_validate_json(text, strict=True)
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
def make_model(name: str, fields: tuple[Field, ...]) -> "type[BaseModel]":
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
        former = {name: text for each in known for name, text in each.replaces.items()}
        right = former.get(names[-1]) or nearest(names[-1], [f.name for f in known])
        return BadInput(f"unknown setting '{dotted}'", where=where, right=right)
    if error["type"] == "missing" and len(names) == len(error["loc"]):
        return Missing(f"setting '{dotted}' is missing", where=where, right=field and field.allowed)
    given = cut(json.dumps(error["input"], default=str))
    fault = "is not allowed" if finite(error["input"]) else "is not a finite number"
    right = field.allowed if field else error["msg"]
    if field and field.group:
        right += f": {', '.join(inner.name for inner in field.group)}"
    return BadInput(f"{dotted} = {given} {fault}", where=where, right=right)
