"""The record of an action: what was evaluated, and which objects came of it."""

import json
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from hairpipe.graph.canonical import digest_bytes
from hairpipe.graph.key import Parts

MARK = ',"check":"'


class Output(NamedTuple):
    """An object by name and size [bytes], and the objects it refers to: a file with companions is a list of files."""

    object: str
    size: int
    parts: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True)
class Record:
    """One evaluation, as the store remembers it.

    outputs    by name; the output named `state` of a scan may have been thinned away
    seconds    that the evaluation took [s]
    created    when, in seconds since 1970 [s]
    processor  seconds of all its threads, which a busy machine changes less [s]; None in records of older versions
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
    """Read a record; None where a single byte of it is not as written."""
    body, mark, check = text.rpartition(MARK)
    if not mark or check != digest_bytes("record", f"{body}}}".encode()) + '"}':
        return None
    return from_fields(json.loads(body + "}"))


def from_fields(fields: dict[str, Any]) -> Record:
    """Build a record from its fields as JSON gives them; those that another version has added are left out."""
    known = {name: value for name, value in fields.items() if name in Record.__dataclass_fields__}
    outputs = {name: Output(o[0], o[1], tuple(map(tuple, o[2]))) for name, o in fields["outputs"].items()}
    return Record(**known | {"outputs": outputs, "warnings": tuple(fields["warnings"])})
