"""The record of an action: what was evaluated, and which objects came of it."""

import json
import math
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from hairpipe.engine.store.digest import DIGEST, Parts, digest_bytes, is_key, parsed

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


def read_record(text: str) -> Record | None:
    """Read a record; None where it is damaged, or no record of hairpipe."""
    body, mark, check = text.rpartition(MARK)
    if not mark or check != digest_bytes("record", f"{body}}}".encode()) + '"}':
        return None
    try:
        record = from_fields(parsed(body + "}"))
        return record if is_sound(record) else None
    except (ValueError, TypeError, KeyError, IndexError, AttributeError):
        return None


def from_fields(fields: dict[str, Any]) -> Record:
    """Build a record from its fields as in JSON; fields of other versions are ignored."""
    known: dict[str, Any] = {name: value for name, value in fields.items() if name in Record.__dataclass_fields__}
    outputs = {name: Output(o[0], o[1], tuple(map(tuple, o[2]))) for name, o in fields["outputs"].items()}
    lists = {"warnings": fields["warnings"], "prepare_warnings": fields.get("prepare_warnings", [])}
    if not all(isinstance(texts, list) for texts in lists.values()):
        raise TypeError("warnings are lists of texts")
    known |= {"outputs": outputs} | {name: tuple(texts) for name, texts in lists.items()}
    return Record(**known)


def is_sound(record: Record) -> bool:
    """Whether everything in a record has the type that it is used as, and every name is valid."""
    parts = record.parts
    numbers = (record.seconds, record.created, 0.0 if record.processor is None else record.processor)
    return (
        is_key(record.key)
        and isinstance(record.node, str)
        and isinstance(record.frame, int | None)
        and parts.keys() == {"type", "code", "settings", "inputs", "time"}
        and all(isinstance(parts[name], str) for name in ("type", "code"))
        and all(isinstance(parts[name], dict) for name in ("settings", "inputs"))
        and isinstance(parts["time"], dict | None)
        and all(is_object(name) and type(size) is int and size >= 0 for name, size in record.objects())
        and (record.state is None or record.state in record.outputs)
        and isinstance(record.processor_class, str | None)
        and isinstance(record.threading_layer, str | None)
        and all(isinstance(number, int | float) and math.isfinite(number) for number in numbers)
        and all(isinstance(text, str) for text in (*record.warnings, *record.prepare_warnings))
    )


def is_object(name: Any, *suffixes: str) -> bool:
    """Whether something is the name of an object, of these kinds or of any: it becomes a path."""
    if not isinstance(name, str):
        return False
    stem, dot, suffix = name.partition(".")
    return DIGEST.fullmatch(stem) is not None and dot + suffix in (suffixes or SUFFIXES)
