"""Values sent between two processes: JSON, followed by the bytes of arrays.

The sender may have read a damaged file and is not trusted: the data names no code, and only dataclasses and NamedTuples
of this package.
"""

import dataclasses
import importlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from hairpipe.errors import BadInput

NUMBERS = "biuf"
"""Kinds of arrays that are sent: bool, integers with and without sign, floats."""
OURS = "hairpipe."


def pack(value: Any) -> bytes:
    """Write a value of None, numbers, texts, paths, arrays, lists, tuples, dicts, faults, and records of these.

    TypeError for other types.
    """
    arrays: list[np.ndarray] = []
    head = json.dumps(plain(value, arrays)).encode()
    return b"".join([head, b"\n", *(np.ascontiguousarray(array).data for array in arrays)])


def unpack(data: bytes | bytearray) -> Any:
    """Read a value; ValueError, KeyError or TypeError for invalid data."""
    end = data.find(b"\n")
    return Reader(memoryview(data)[end + 1 :]).build(json.loads(data[:end]))


def plain(value: Any, arrays: list[np.ndarray]) -> Any:
    """Convert a value to JSON, with arrays in a list; other types are pairs of kind and content."""
    value = value.item() if isinstance(value, np.generic) else value
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Path):
        return ["path", os.fspath(value)]
    if isinstance(value, BadInput):
        return ["fault", [plain(part, arrays) for part in (value.what, value.where, value.right)]]
    if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS:
        arrays.append(value)
        return ["array", [value.dtype.str, value.shape]]
    if isinstance(value, dict):
        return ["dict", [[plain(key, arrays), plain(item, arrays)] for key, item in value.items()]]
    if type(value) in (list, tuple):
        return [type(value).__name__, [plain(item, arrays) for item in value]]
    fields = fields_of(type(value))
    return [f"{type(value).__module__}:{type(value).__qualname__}", [plain(getattr(value, f), arrays) for f in fields]]


def fields_of(kind: type) -> tuple[str, ...]:
    """List the fields of a dataclass or NamedTuple of ours; TypeError for any other class."""
    if kind.__module__.startswith(OURS) and dataclasses.is_dataclass(kind):
        return tuple(field.name for field in dataclasses.fields(kind))
    if kind.__module__.startswith(OURS) and issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return tuple(vars(kind)["_fields"])
    raise TypeError(f"a {kind.__qualname__} is not sent to another process")


class Reader:
    """Builder of values from JSON and the bytes of their arrays."""

    def __init__(self, rest: memoryview) -> None:
        self.rest = rest
        self.at = 0

    def build(self, tree: Any) -> Any:
        """Build a value from JSON."""
        if not isinstance(tree, list):
            return tree
        kind, content = tree
        if kind == "path":
            return Path(content)
        if kind == "array":
            return self.array(*content)
        if kind == "dict":
            return {self.build(key): self.build(item) for key, item in content}
        items = [self.build(item) for item in content]
        if kind in ("list", "tuple"):
            return items if kind == "list" else tuple(items)
        if kind == "fault":
            what, where, right = items
            return BadInput(what, where=where, right=right)
        return record_named(kind)(*items)

    def array(self, dtype: str, shape: list[int]) -> np.ndarray:
        """Copy the next array, so that it is writable."""
        kind = np.dtype(dtype)
        count = int(np.prod(shape))
        found = np.frombuffer(self.rest, kind, count, self.at).reshape(shape).copy()
        self.at += count * kind.itemsize
        return found


def record_named(name: str) -> type:
    """Find a dataclass or NamedTuple of ours by its name; TypeError for another class."""
    module, _, own = name.partition(":")
    kind = getattr(importlib.import_module(module), own, None) if module.startswith(OURS) else None
    if not isinstance(kind, type) or kind.__module__ != module:
        raise TypeError(f"{name} is not a record of hairpipe")
    fields_of(kind)
    return kind
