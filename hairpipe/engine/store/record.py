"""The record of an action: what was evaluated, and which objects came of it."""

import json
from dataclasses import asdict, dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from hairpipe.engine.store.digest import DIGEST, Parts, digest_bytes, is_key

if TYPE_CHECKING:
    from pydantic import TypeAdapter

MARK = ',"check":"'
SUFFIXES = (".h5", ".bin", ".set")
"""Of objects: a value, the bytes of a file, a file with companions."""


class Output(NamedTuple):
    """An object by name and size [bytes], and the objects it refers to: a file with companions is a list of files."""

    object: str
    size: int
    parts: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, repr=False)
class Record:
    """One evaluation, as the store remembers it.

    outputs    by name; the output named `state` of a scan may have been thinned away
    seconds    that the evaluation took [s]
    created    when, in seconds since 1970 [s]
    processor  seconds of all its threads and children, which a busy machine changes less [s]; None in older records
    prepare_warnings  of the function that prepared the node: the same at every frame
    processor_class  of the processor that evaluated it; None in older records
    threading_layer  of numba in that process; None where nothing was computed in parallel, and in older records
    """

    key: str
    node: str
    frame: int | None
    parts: Parts
    outputs: dict[str, Output]
    state: str | None
    seconds: float
    warnings: tuple[str, ...]
    created: float
    processor: float | None = None
    prepare_warnings: tuple[str, ...] = ()
    processor_class: str | None = None
    threading_layer: str | None = None

    def __repr__(self) -> str:
        """Write node, frame, type, seconds and size."""
        frame = "" if self.frame is None else f"@{self.frame}"
        return f"<Record {self.node}{frame}: {self.parts['type']}, {self.seconds:.3g} s, {self.size:,} bytes>"

    @property
    def size(self) -> int:
        """Bytes of all objects."""
        return sum(o.size + sum(size for _, size in o.parts) for o in self.outputs.values())

    def objects(self, without: str | None = None) -> list[tuple[str, int]]:
        """List names and sizes of all objects but those of the output `without`."""
        kept = [output for name, output in self.outputs.items() if name != without]
        return [pair for output in kept for pair in ((output.object, output.size), *output.parts)]


def write_record(record: Record) -> str:
    """Write a record as JSON that carries its own check."""
    text = json.dumps(asdict(record), separators=(",", ":"))
    return f'{text[:-1]}{MARK}{digest_bytes("record", text.encode())}"}}'


@cache
def records() -> "TypeAdapter[Record]":
    """Return the reader of records, which ignores fields of other versions."""
    from pydantic import ConfigDict, TypeAdapter, with_config

    return TypeAdapter(with_config(ConfigDict(allow_inf_nan=False))(Record))


def read_record(text: str) -> Record | None:
    """Read a record; None where it is damaged, or no record of hairpipe."""
    body, mark, check = text.rpartition(MARK)
    if not mark or check != digest_bytes("record", f"{body}}}".encode()) + '"}':
        return None
    try:
        record = records().validate_json(body + "}", strict=True)
    except ValueError:
        return None
    parts = record.parts
    is_sound = (
        is_key(record.key)
        and parts.keys() == {"type", "code", "settings", "inputs", "time"}
        and all(isinstance(parts[name], str) for name in ("type", "code"))
        and all(isinstance(parts[name], dict) for name in ("settings", "inputs"))
        and isinstance(parts["time"], dict | None)
        and all(is_object(name) and size >= 0 for name, size in record.objects())
        and (record.state is None or record.state in record.outputs)
    )
    return record if is_sound else None


def is_object(name: Any, *suffixes: str) -> bool:
    """Whether something is the name of an object, of these kinds or of any: it becomes a path."""
    if not isinstance(name, str):
        return False
    stem, dot, suffix = name.partition(".")
    return DIGEST.fullmatch(stem) is not None and dot + suffix in (suffixes or SUFFIXES)
