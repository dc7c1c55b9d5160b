"""`@value`: the declaration of a type that edges transport, and the short text of its values.

Fields are arrays, bool, int, float, text, tuples of texts, other values, dicts of those by name, or None:

    @value
    class Springs:
        lengths: np.ndarray

The docstring of the class has a line for each field, `lengths  at rest [m], (n,) float64`, which states the unit.
"""

import dataclasses
import re
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar, dataclass_transform

import numpy as np

Type = TypeVar("Type", bound=type)
FIELD = re.compile(r"^ *(\w+) +(.*)$", re.MULTILINE)
UNIT = re.compile(r"(?<!\S)\[([^]|]+)\]")
"""A unit in the docstring line of a field: [m]; neither an index, offsets[s], nor the columns of a matrix, [R | p]."""
MOST_SHOWN = 4
"""Numbers of an array, and texts of a tuple, that are written one by one."""


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(dataclasses.field,))
def value(cls: Type) -> Type:
    """Declare a class as a frozen dataclass that is compared by identity and printed as a summary, see `summary_of`."""
    setattr(cls, "__repr__", summary_of)  # noqa: B010 - to a type checker every class has a method of its own
    return dataclasses.dataclass(frozen=True, eq=False)(cls)


def summary_of(value: Any) -> str:
    """Write a value, a line for each field: name, shape and type, unit, and range of the numbers."""
    return "\n".join([type(value).__name__, *indented(rows_of(value))])


def indented(rows: list[tuple[str, str]]) -> Iterator[str]:
    """Lay out rows of names and texts in two columns; the other lines of a text stand below its first."""
    width = max((len(name) for name, _ in rows), default=0)
    for name, text in rows:
        first, *others = text.splitlines()
        yield f"  {name:{width}}  {first}"
        yield from (f"  {line}" for line in others)


def rows_of(value: Any) -> list[tuple[str, str]]:
    """Describe the fields of a value, and the entries of those that are dicts: names and texts."""
    units = units_of(type(value))
    rows = []
    for field in dataclasses.fields(value):
        held = getattr(value, field.name)
        if isinstance(held, Mapping) and held:
            rows += [(f"{field.name}[{key!r}]", described(item, "")) for key, item in held.items()]
        else:
            rows.append((field.name, described(held, units.get(field.name, ""))))
    return rows


def units_of(cls: type) -> dict[str, str]:
    """Read the units of fields from the docstring of their class; of several, all are given."""
    lines = {name: UNIT.findall(text) for name, text in FIELD.findall(cls.__doc__ or "")}
    return {name: ", ".join(dict.fromkeys(units)) for name, units in lines.items() if units}


def described(held: Any, unit: str) -> str:
    """Describe what a field holds, with its unit, on one line; another value on several."""
    if isinstance(held, np.ndarray):
        shape = f"{held.shape} {held.dtype}"
        return "  ".join(filter(None, [shape, unit and f"[{unit}]", range_of(held)]))
    if isinstance(held, tuple) and held:
        shown = ", ".join(map(repr, held[:MOST_SHOWN]))
        return shown if len(held) <= MOST_SHOWN else f"{shown}, ... {len(held):,} in all"
    return f"{held!r} [{unit}]" if unit and held is not None else repr(held)


def range_of(array: np.ndarray) -> str:
    """Write the numbers of a short array, or the smallest and the largest one, and how many are not finite."""
    if array.size <= MOST_SHOWN or array.dtype.kind not in "biuf":
        return np.array2string(array, precision=4).replace("\n", "") if array.size <= MOST_SHOWN else ""
    if array.dtype.kind == "b":
        return f"{np.count_nonzero(array):,} true"
    finite = array[np.isfinite(array)]
    lost = "" if finite.size == array.size else f"{array.size - finite.size:,} not finite"
    ends = f"{finite.min() + 0:.4g} to {finite.max() + 0:.4g}" if finite.size else ""
    return ", ".join(filter(None, [ends, lost]))
